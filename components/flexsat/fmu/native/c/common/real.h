/* The numbers that the step of the controller computes with: doubles in FMUs. The controller alone is also exported
with floats (`flexsat export-c`); what has to be exact or is added up over a run is a double there too: times,
attitudes, the reference and the plans of slews. */
#ifndef FLEXSAT_REAL_H
#define FLEXSAT_REAL_H

#ifdef FLEXSAT_FLOATS
typedef float Real;
#else
typedef double Real;
#endif

#endif
