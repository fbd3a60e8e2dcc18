"""Shared by all clients: the lab's offers, found by the names that clients use."""

from ..offers.goals import Goals
from ..offers.offer import Action, Offers, Service, Topic
from .hidden import Hidden
from .rosapi import full, rosapi_services


class Rooms:
    """A leading slash is optional; `rosapi` and the services behind an action are found too."""

    def __init__(self, offers: Offers, goals: Goals) -> None:
        self.offers = offers
        self.goals = goals
        self._hidden = Hidden(offers, goals)
        self._rosapi = rosapi_services(offers)

    def action(self, name: str) -> Action | None:
        """An action by its name."""
        return self.offers.actions.get(full(name))

    def service(self, name: str) -> Service | None:
        """A service by its name."""
        found = self.offers.services.get(full(name)) or self._rosapi.get(full(name))
        return found or self._hidden.service(full(name))

    def topic(self, name: str) -> Topic | None:
        """A topic by its name."""
        return self.offers.topics.get(full(name)) or self._hidden.topic(full(name))
