"""A race that was decided before its run failed."""


def test_what_a_loser_had_set_is_set_again_after_its_device_was_touched(own_device):
    device = own_device()

    def watch(event):
        if event.event == "feedback" and event.path.endswith("/slow"):
            device.answer("enough", "yes")

    first = device.run(
        """
steps:
  - any:
      - steps:
          - {do: a.act, with: {name: early}}
          - {id: slow, do: a.act, with: {name: slow, script: hang}}
      - steps: [{id: enough, confirm: Enough?}]
  - {do: a.act, with: {name: late, script: "Broken,ok"}}
""",
        watch=watch,
    )

    ran = device.resume()

    assert (first.status, ran.status) == (1, 0)
    assert ran.sent() == ["early", "slow", "late", "early", "late"]
