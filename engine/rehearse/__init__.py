"""Rehearsal: the whole protocol with twins on a virtual clock, hours in seconds."""
