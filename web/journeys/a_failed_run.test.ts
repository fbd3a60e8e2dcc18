// Runs in which something goes wrong.
import './runs_trouble'
