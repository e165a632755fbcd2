"""Faults on connections and parameters, from a scenario file: `--faults FILE`, which may be given several times.

  [[fault]]
  name = "wheel 3 lost"                        # optional; for the events
  connection = "plant.wheel.torque[3]"         # an input of a component; or "producer.x -> consumer.y"
  kind = "scale"
  factor = 0.0
  from = 50.0                                  # s; to = 80.0, or to the end of the run; or at and duration

A connection is a pattern or a list of patterns: * and ? are wildcards, the name of an array stands for all its
elements, and x[1..3] is a range. Elements are in the order of their indices. Instead of a connection, parameter =
"plant.x" names tunable parameters, or inputs that are not connected; they are set at each step of their component in
the window, and set back after it.

  stuck         the last value before the window; or value
  bias          value is added
  scale         multiplied by factor
  noise         normal, with standard deviation `deviation`, drawn at each transfer; seed
  dropout       Booleans become false and all other values are held; validity names more flags, also numbers, and
                invalid the number that they become (default 0)
  delay         the value transferred at least `ticks` ticks of the system earlier; history is kept from the start
  quantisation  rounded to multiples of step
  spike         value is added to the first transfer in the window; or, with probability = p and seed, with a random
                sign to each
  nan           not a number; the master transfers it, and the consumer's reaction decides what happens

Values are numbers, or lists with one number for each element, in the units of the consumer's FMU; unit = "deg/s" gives
another unit. A stuck value may also be true, false, a text, or the name of an Enumeration item.

A fault acts on the values transferred at times t with from <= t < to. A value that the consumer already holds stays
until the next transfer: faults on the commands of a controller of 5 ms begin and end with its steps. A window without a
transfer is refused. Values exchanged before the first step are not altered. Several faults on one value act in the
order of the file, each on the result of the ones before, and each with its own memory: stuck and delay refer to the
values that reach them. Noise and random spikes depend on seed, names and time alone, not on other faults nor on the
recording. Integers are rounded to the nearest and saturate at the limits of their type; on Booleans only stuck, dropout
and delay act.
"""

HELP = str(__doc__)  # of the command lines
