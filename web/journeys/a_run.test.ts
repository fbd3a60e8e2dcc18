// Runs: the first of these journeys sees a bench where nothing was run.
import './runs'
