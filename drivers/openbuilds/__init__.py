"""A gantry behind the program OpenBuilds CONTROL."""
