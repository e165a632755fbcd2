"""Faults on connections and parameters, from a scenario file: `--faults FILE`, which may be given several times.

  [[fault]]
  name = "wheel 3 lost"                        # optional; for the events
  connection = "plant.wheel.torque[3]"         # what a consumer receives; or "producer.x -> consumer.y"
  kind = "scale"
  factor = 0.0
  from = 50.0                                  # s; to = 80.0, or to the end of the run; or at and duration

A connection is a pattern or a list of them: * and ? are wild, an array's name is all its elements, [1..3] a range.
In place of it, parameter = "plant.x" names tunable parameters, or inputs that nothing feeds; they are set at each step
of their component in the window, and set back after it.

  stuck         the last value before the window; or value
  bias          value is added
  scale         times factor
  noise         normal, with standard deviation `deviation`, anew at each transfer; seed
  dropout       Booleans become false and all else is held; validity names more flags, also numbers, and invalid what
                number they become (default 0)
  delay         what was transferred at least `ticks` ticks of the system earlier; history is kept from the start on
  quantisation  rounded to multiples of step
  spike         value is added to the first transfer in the window; or, with probability = p and seed, with a random
                sign to each
  nan           not a number; the master lets it pass to the consumer, whose own reaction decides what happens then

Values are numbers, or lists with one an element, in the units of the consumer's FMU; unit = "deg/s" gives another.
Where something is stuck they may also be true, false, a text, or the name of an Enumeration's item.

A fault acts on the values that are transferred at times t with from <= t < to. A value that the consumer already
holds stays until the next transfer: faults on what a controller of 5 ms commands begin and end with its steps. A
window that meets no transfer is refused. What components exchange before the first step is not altered. Several
faults on one value act in the order of the file, each on what those before it made, and each keeps its own memory:
stuck and delay refer to what reaches them. Noise and random spikes depend on seed, names and time alone, not on other
faults nor on what is recorded. Integers are rounded to the nearest; on Booleans only stuck, dropout and delay act.
"""

HELP = str(__doc__)  # of the command lines
