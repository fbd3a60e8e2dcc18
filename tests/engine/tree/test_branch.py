"""A branch that was taken is kept over a resume."""


def test_the_branch_that_was_taken_is_kept_when_its_condition_no_longer_holds(own_device):
    device = own_device()
    first = device.run("""
steps:
  - {id: look, do: a.act, with: {name: look}}
  - if: "${{ steps.look.n == 1 }}"
    then: [{do: a.act, with: {name: then, script: "Broken,ok"}}]
    else: [{do: a.act, with: {name: else}}]
""")

    ran = device.resume()

    assert (first.status, ran.status) == (1, 0)
    assert ran.sent() == ["look", "then", "look", "then"]
