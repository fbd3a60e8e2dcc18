"""Device contracts that ship with labrun, one YAML file each."""
