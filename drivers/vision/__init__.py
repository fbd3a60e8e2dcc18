"""What a camera above a bench can know: where it is, how deep things lie, where a pixel points."""
