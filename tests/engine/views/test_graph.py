"""`labrun graph` draws the compiled tree: one node per step, and nothing that a label could break."""

import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from labrun.engine.check import Checked, check_file, check_text
from labrun.engine.journal.history import History
from labrun.engine.journal.journal import Journal
from labrun.engine.run.frame import Scope
from labrun.engine.run.questions import Questions
from labrun.engine.run.run import Run
from labrun.engine.tree.compile import TreeCompiler
from labrun.engine.tree.nodes.background import Background
from labrun.engine.tree.nodes.step import StepNode
from labrun.engine.views.forecast import outlook
from labrun.engine.views.graph.dot import dot
from labrun.engine.views.graph.dot import escaped as dot_escaped
from labrun.engine.views.graph.mermaid import escaped, mermaid
from labrun.engine.views.graph.node import Node
from labrun.engine.views.graph.tree import phases

PROTOCOLS = Path(__file__).parents[3] / "protocols"
SHIPPED = sorted([*PROTOCOLS.glob("*.yaml"), *PROTOCOLS.glob("*.json")])
EXAMPLE = Path(__file__).parents[1] / "examples" / "libs_grid_scan.yaml"
NASTY = (
    '1. end "x" #quot; ]]>}) %%{init}%% `a` **b** _c_ \\ | ; & &lt; ünï 中文 fa:fa-car --> <b> \n\t'
)
EVERY = """\
labrun: 1
name: every kind
devices: {gantry: gantry@1, libs: libs_analyzer@1}
defaults: {timeout: 30 s, retry: 2}
steps:
  - {id: both, parallel: [{do: gantry.home}, {id: aside, steps: [{do: libs.locate}]}], retry: 2}
  - {any: [{do: libs.locate}, {do: gantry.home, when: "${{ run.simulated }}"}]}
  - set: {far: 3 mm}
  - id: loop
    foreach: {i: [1, 2, 3]}
    steps:
      - {id: go, do: gantry.move_to, with: {x: "${{ far }}"}, timeout: 5 s, on_error: continue}
      - {do: libs.locate, mode: background}
  - {repeat: 2, steps: [{wait: 1 s}]}
  - {while: "${{ steps.loop.failed > 0 }}", max: 3, steps: [{log: again}]}
  - {if: "${{ steps.loop.failed > 0 }}", then: [{fail: no}], else: [{require: "${{ true }}"}]}
  - do: libs.locate
    fallback: [[{log: one}, {do: libs.reconnect}], {ask: "And now?", choices: [repeat, stop]}]
  - {confirm: "Go on?", timeout: 1 min}
on_resume: [{do: gantry.home}]
finally: [{do: libs.disarm}]
"""


def trees(checked: Checked) -> dict[str, Node]:
    assert checked.ok, checked.problems
    return phases(outlook(checked))


def compiled(checked: Checked, folder: Path) -> list[str]:
    """The paths of all steps of the compiled tree; a background step is built when it starts."""
    assert checked.survey is not None and checked.protocol is not None
    journal = Journal(folder / "journal.jsonl", sync=False)
    run = Run("r", folder, journal, History(), checked.roles, checked.params, {}, Questions())
    compiler = TreeCompiler(run, None, checked.survey, folder)  # type: ignore[arg-type]
    found = []
    for steps in (checked.protocol.steps, checked.protocol.on_resume, checked.protocol.finally_):
        for node in compiler.sequence(steps, Scope()).iterate():
            if isinstance(node, StepNode):
                found.append(node.rules.segment)
            assert not isinstance(node, Background) or isinstance(node.parent, StepNode)
    journal.close()
    return found


@pytest.mark.parametrize("path", [*SHIPPED, EXAMPLE], ids=lambda path: path.stem)
def test_the_drawing_has_the_steps_of_the_compiled_tree(path, tmp_path):
    checked = check_file(path)
    drawn = [node.step for tree in trees(checked).values() for node in tree.all() if node.step]

    assert Counter(drawn) == Counter(compiled(checked, tmp_path))


def test_every_kind_of_step_is_drawn_once_as_it_is_compiled(tmp_path):
    checked = check_text(EVERY, "every.yaml")
    nodes = [node for tree in trees(checked).values() for node in tree.all()]
    drawn = [node.step for node in nodes if node.step is not None]

    assert Counter(drawn) == Counter(compiled(checked, tmp_path))
    assert "both/aside/0" in drawn and "6/then/0" in drawn
    assert {node.kind for node in nodes} == {
        "sequence", "set", "loop", "branch", "retry", "fallback", "guard", "action", "person", "instant",
    }  # fmt: skip


def test_iterations_at_once_are_drawn_with_their_order():
    loop = "steps: [{foreach: {i: [1, 2]}, at_once: 2, order: shortest, steps: [{wait: 1 s}]}]\n"
    said = mermaid(trees(check_text(f"labrun: 1\nname: p\n{loop}", "p.yaml")))

    assert "2 at once in the shortest order" in said


def test_a_grid_of_a_thousand_points_is_one_node():
    said = mermaid(trees(check_file(EXAMPLE)))

    assert said.count("{{") == 1 and "a grid of 21 x 51 = 1,071" in said
    assert said.startswith("flowchart TD\n") and said.count("subgraph") == 3


def test_labels_of_mermaid_hold_nothing_that_ends_them():
    label = escaped(NASTY)

    assert not re.search(r'["<>`*|\\%\n\t]', label) and "fa:" not in label
    assert all(re.fullmatch(r"#\d+;.*", part) for part in re.findall(r"#.{4}", label))
    assert "ünï 中文" in label


def test_every_line_of_mermaid_is_a_statement_of_its_grammar():
    text = EVERY.replace("And now?", NASTY.strip().replace("\\", "\\\\").replace('"', '\\"'))
    statement = re.compile(
        r'flowchart TD|subgraph phase\d+\["[^"]*"\]|end'
        r'|n\d+[\[\](){}>/\\]+"[^"]+"[\[\](){}/\\]+:::\w+Node'
        r'|n\d+ -->(\|"[^"]+"\|)? n\d+|classDef \w+Node fill:#\w+,stroke:#\w+,color:#\w+'
    )
    lines = mermaid(trees(check_text(text, "every.yaml"))).splitlines()

    assert [line for line in lines if not statement.fullmatch(line.strip())] == []


def test_every_line_of_dot_is_a_statement_of_its_grammar():
    text = EVERY.replace("And now?", NASTY.strip().replace("\\", "\\\\").replace('"', '\\"'))
    quoted = r'"(?:[^"\\]|\\.)*"'
    statement = re.compile(
        rf"digraph protocol {{|}}|subgraph cluster_\d+ {{|(graph|node|edge) \[[^\]]*\];"
        rf"|label={quoted}; color={quoted};|color=none;"
        rf"|n\d+ \[label={quoted}, shape=\w+, (style={quoted}, )?fillcolor={quoted}, color={quoted}\];"
        rf"|n\d+ -> n\d+( \[label={quoted}\])?;"
    )
    lines = dot(trees(check_text(text, "every.yaml"))).splitlines()

    assert [line for line in lines if not statement.fullmatch(line.strip())] == []
    assert dot_escaped('a "b" \\n') == 'a \\"b\\" \\\\n'


@pytest.mark.needs("graphviz")
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_graphviz_draws_it(path):
    done = subprocess.run(
        ["dot", "-Tsvg"], input=dot(trees(check_file(path))), capture_output=True, text=True,
        check=False,
    )  # fmt: skip

    assert (done.returncode, done.stderr) == (0, "")
    assert "<svg" in done.stdout
