// The text editor: CodeMirror with what a protocol needs, and nothing else.
import { defaultKeymap, history, historyKeymap, indentWithTab, redo, undo } from '@codemirror/commands'
import { yaml } from '@codemirror/lang-yaml'
import { bracketMatching, foldGutter, foldKeymap, HighlightStyle, indentOnInput, indentService, indentUnit, syntaxHighlighting } from '@codemirror/language'
import { lintGutter, lintKeymap, nextDiagnostic, previousDiagnostic } from '@codemirror/lint'
import { Compartment, EditorState, type Extension } from '@codemirror/state'
import { drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from '@codemirror/view'
import { tags } from '@lezer/highlight'

export const writable = new Compartment()

const COLOURS = HighlightStyle.define([
  { tag: tags.comment, color: 'var(--muted)', fontStyle: 'italic' },
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: 'var(--accent)' },
  { tag: [tags.string, tags.special(tags.string)], color: 'var(--ok)' },
  { tag: [tags.labelName, tags.typeName, tags.keyword], color: 'var(--paused)' },
  { tag: [tags.separator, tags.punctuation, tags.squareBracket, tags.brace], color: 'var(--muted)' },
])

const LOOK = EditorView.theme({
  '&': { height: '100%', color: 'var(--text)', backgroundColor: 'var(--bg)', fontSize: '13.5px' },
  '.cm-scroller': { fontFamily: 'var(--mono)', lineHeight: '1.5' },
  '.cm-content': { caretColor: 'var(--text)' },
  '.cm-cursor': { borderLeftColor: 'var(--text)' },
  '&.cm-focused': { outline: '2px solid var(--accent)', outlineOffset: '-2px' },
  '.cm-gutters': { backgroundColor: 'var(--panel)', color: 'var(--muted)', borderRight: '1px solid var(--line)' },
  '.cm-activeLine': { backgroundColor: 'color-mix(in srgb, var(--picked) 45%, transparent)' },
  '.cm-activeLineGutter': { backgroundColor: 'var(--picked)', color: 'var(--text)' },
  '&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground': { backgroundColor: 'color-mix(in srgb, var(--accent) 28%, transparent)' },
  '.cm-tooltip': { backgroundColor: 'var(--raised)', color: 'var(--text)', border: '1px solid var(--line-strong)', borderRadius: '6px', maxWidth: '520px' },
  '.cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]': { backgroundColor: 'var(--picked)', color: 'var(--text)' },
  '.cm-completionDetail, .cm-completionInfo': { color: 'var(--muted)', fontStyle: 'normal' },
  '.cm-completionMatchedText': { textDecoration: 'none', fontWeight: '700' },
  '.cm-completionIcon': { display: 'none' },
  '.cm-panels': { backgroundColor: 'var(--panel)', color: 'var(--text)', borderColor: 'var(--line)' },
  '.cm-diagnostic': { padding: '4px 8px', fontFamily: 'var(--font)' },
  '.cm-diagnostic-error': { borderLeft: '4px solid var(--fail)' },
  '.cm-diagnostic-warning': { borderLeft: '4px solid var(--warn)' },
  '.cm-diagnosticAction': { backgroundColor: 'var(--accent)', color: 'var(--on-accent)' },
  '.cm-foldPlaceholder': { backgroundColor: 'var(--panel)', color: 'var(--muted)', border: '1px solid var(--line-strong)' },
  '.cm-hover-doc': { padding: '6px 10px', fontFamily: 'var(--font)', fontSize: '13.5px' },
  '.cm-matchingBracket': { backgroundColor: 'var(--picked) !important', color: 'inherit !important' },
})

/** Below a key that ends its line: further in than the key, which may stand behind a dash. */
const WITHIN = indentService.of((context, at) => {
  const key = context.simulatedBreak === at ? /^((?:\s|- )*)[^\s#].*:\s*$/.exec(context.lineAt(at, -1).text) : null
  return key ? (key[1]?.length ?? 0) + 2 : undefined
})

/** A long day of edits: the first of them can still be undone. */
const UNDOABLE = 10_000

export interface Keys {
  save(): void
  fix(): boolean
}

function keys({ save, fix }: Keys): Extension {
  return keymap.of([
    { key: 'Mod-s', preventDefault: true, run: () => (save(), true) },
    { key: 'F8', run: nextDiagnostic }, { key: 'Shift-F8', run: previousDiagnostic },
    { key: 'Mod-.', run: fix },
    ...historyKeymap, ...foldKeymap, ...lintKeymap,
    indentWithTab, ...defaultKeymap,
  ])
}

/** Who goes on by Tab has not come to write, and after Esc is done with it: no keyboard trap. Any other key, and a click, end it. */
const TAB_LEAVES = EditorView.domEventHandlers({
  focus: (_, view) => view.setTabFocusMode(3_600_000),
  click: (_, view) => view.setTabFocusMode(false),
})

export function stateOf(doc: string, bindings: Keys, more: Extension): EditorState {
  return EditorState.create({
    doc,
    extensions: [
      more, EditorState.lineSeparator.of('\n'), EditorView.lineWrapping, lineNumbers(), highlightActiveLineGutter(), foldGutter(), lintGutter(), history({ minDepth: UNDOABLE }), drawSelection(),
      indentOnInput(), bracketMatching(), highlightActiveLine(), yaml(), indentUnit.of('  '), WITHIN, EditorView.clipboardInputFilter.of((pasted) => pasted.replace(/\r\n?/g, '\n')), syntaxHighlighting(COLOURS), LOOK, TAB_LEAVES, keys(bindings),
      EditorView.contentAttributes.of({ 'aria-label': 'Protocol YAML', tabindex: '0' }), writable.of([]),
    ],
  })
}

export function readOnly(on: boolean): Extension {
  return on ? [EditorState.readOnly.of(true), EditorView.editable.of(false)] : []
}

export { redo, undo }
