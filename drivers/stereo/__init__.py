"""What two eyes above a bench can know: where they are, how deep things lie, where a pixel points."""
