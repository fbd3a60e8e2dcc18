"""A gantry behind GRBL 1.1 or grblHAL on a serial port."""
