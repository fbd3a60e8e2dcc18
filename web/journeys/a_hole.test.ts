// Runs of which points failed.
import './runs_holes'
