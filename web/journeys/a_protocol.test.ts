// The frame and its protocols, on one bench, in this order.
import './frame'
import './protocols'
