// What was measured, on one bench, in this order: the first sees it empty.
import './results'
import './finding'
import './screens'
