"""The driver of an analyser's desktop program, by keyboard and mouse."""
