"""Who may ask for what: hosts, origins, sessions, control, and commands that are done once."""
