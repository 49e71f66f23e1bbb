#ifndef SAMARA_CODEBOOKS_CAPI_SAMARA_H
#define SAMARA_CODEBOOKS_CAPI_SAMARA_H

#include <stddef.h>

/* Codebooks for other languages, through C: open, query, close. Link samara::c.
 *
 * Numbers are in SI units, angles in rad. No exception and no text leaves these functions: those that may
 * fail return a status, or a null pointer, and samara_error() says why in one sentence.
 *
 * A codebook may be shared between threads; a query holds scratch space, one per thread. Answers do not
 * allocate, except batches on several threads, those of derived outputs, and the first one in a piece of a
 * large file that was not read yet.
 */

#ifdef __cplusplus
extern "C" {
#endif

typedef enum samara_status {
  SAMARA_DONE = 0,
  SAMARA_INTERNAL = 1,   /* a failure of ours */
  SAMARA_WRONG_CALL = 2, /* an argument that is null, not finite, or means nothing */
  SAMARA_BAD_FILE = 3,   /* a file that is missing, damaged, or no codebook */
  SAMARA_OUTSIDE = 5     /* a point outside the box, or in a gap between pieces */
} samara_status;

typedef struct samara_codebook samara_codebook;
typedef struct samara_query samara_query;
typedef struct samara_trajectory samara_trajectory;

/* What the last call in this thread that failed has to say; "" before. Valid until the next one. */
const char* samara_error(void);

/* Of the library, "0.1.0", and the newest format of codebook files that it reads, "0.7". */
const char* samara_version(void);
const char* samara_format_version(void);

/* Null if the file cannot be read. */
samara_codebook* samara_open(const char* path);
/* The same of the bytes of such a file, which need not stay. */
samara_codebook* samara_open_memory(const void* bytes, size_t size);
/* Its queries must be closed before. Null is ignored. */
void samara_close(samara_codebook* book);

/* What a codebook holds ------------------------------------------------------------------------------- */

int samara_coordinate_count(const samara_codebook* book);
int samara_output_count(const samara_codebook* book);
/* Names and units live as long as the codebook. Null for an index that does not exist. */
const char* samara_coordinate_name(const samara_codebook* book, int coordinate);
const char* samara_coordinate_unit(const samara_codebook* book, int coordinate);
/* "time", "space", "parameter", "initial" or "boundary". Time, where there is one, is coordinate 0. */
const char* samara_coordinate_role(const samara_codebook* book, int coordinate);
const char* samara_output_name(const samara_codebook* book, int output);
const char* samara_output_unit(const samara_codebook* book, int output);
/* Ends of the box. */
samara_status samara_bounds(const samara_codebook* book, int coordinate, double* lower, double* upper);
/* Name of the model; "command" of one that was sampled from a program. */
const char* samara_model(const samara_codebook* book);

/* What the model derives from the states that the codebook holds: names that options take like those of
 * outputs. None where not all states are held. */
int samara_derived_count(const samara_codebook* book);
const char* samara_derived_name(const samara_codebook* book, int derived);
const char* samara_derived_unit(const samara_codebook* book, int derived);

/* Parameters and initial values that the plan fixed, by their names. */
int samara_fixed_count(const samara_codebook* book);
const char* samara_fixed_name(const samara_codebook* book, int fixed);
const char* samara_fixed_unit(const samara_codebook* book, int fixed);
samara_status samara_fixed_value(const samara_codebook* book, int fixed, double* value);

/* 1 if the codebook has a certificate that it meets, else 0. */
int samara_is_certified(const samara_codebook* book);

/* Errors against an independent integrator, divided by the range of the output over the box. Errors of a
 * certificate that is not met may be infinite, or NaN where nothing could be measured. */
typedef struct samara_certificate {
  int met;    /* 1: the build converged, nothing failed, and no error exceeds the tolerance */
  int points; /* at which it was measured, each at `times` times */
  int times;
  int failed_points;  /* where the integrator gave no trajectory */
  int wrong_points;   /* where some output errs by more; -1: not known */
  double tolerance;   /* what the plan asked for */
  double max_error;   /* the largest of all outputs */
  double share_above; /* of the box that may err by more, with 95 % confidence; NaN: not known */
  double norm_defect; /* of quaternions as they are stored, the largest; NaN: there are none */
} samara_certificate;
/* Wrong call without a certificate. */
samara_status samara_certificate_of(const samara_codebook* book, samara_certificate* certificate);

/* Of one output; the last in its unit. */
typedef struct samara_output_error {
  double range, max, p95, mean, rms, max_si;
} samara_output_error;
samara_status samara_output_error_of(const samara_codebook* book, int output, samara_output_error* error);

/* Points ---------------------------------------------------------------------------------------------- */

typedef enum samara_precision {
  SAMARA_DOUBLE = 0,
  SAMARA_SINGLE = 1,   /* factors as single floats; points and answers are doubles always */
  SAMARA_AUTOMATIC = 2 /* single floats where the certificate says that nobody will notice */
} samara_precision;

/* Begin with `samara_options options = {0};`, which asks for all stored outputs. */
typedef struct samara_options {
  const char* const* outputs; /* names, stored or derived, in the order wanted; null: all stored ones */
  int output_count;
  const char* const* held; /* names of coordinates that keep a value, and drop out of points */
  const double* held_at;
  int held_count;
  samara_precision precision;
  int as_stored; /* 1: quaternions as the build left them, not of the length with which they began */
} samara_options;

/* Null if memory is short or a piece of the file is damaged. */
samara_query* samara_query_open(const samara_codebook* book);
/* The same as options ask, which are copied; null too for a name that is not known, a value outside the box,
 * or nothing left free. */
samara_query* samara_query_open_with(const samara_codebook* book, const samara_options* options);
void samara_query_close(samara_query* query);

/* Coordinates that are left free, and outputs, as the options have them. */
int samara_query_coordinate_count(const samara_query* query);
int samara_query_output_count(const samara_query* query);
const char* samara_query_coordinate_name(const samara_query* query, int coordinate);
const char* samara_query_output_name(const samara_query* query, int output);
const char* samara_query_output_unit(const samara_query* query, int output);
/* The one that was chosen, where options say automatic. */
samara_precision samara_query_precision(const samara_query* query);

/* All outputs at a point: x has a number per free coordinate, values one per output. */
samara_status samara_values(samara_query* query, const double* x, double* values);
/* The same with derivatives: gradient[output * coordinates + coordinate]. */
samara_status samara_gradient(samara_query* query, const double* x, double* values, double* gradient);
/* Many points, one after the other; threads 0: as many as the machine has. Where an output is derived, one thread
 * answers, whatever `threads` says; so also in the two batches below. */
samara_status samara_batch(samara_query* query, size_t count, const double* points, double* values,
                           int threads);
/* The same with derivatives, those of each point as samara_gradient() has them. */
samara_status samara_batch_gradient(samara_query* query, size_t count, const double* points, double* values,
                                    double* gradients, int threads);

/* Trajectories ---------------------------------------------------------------------------------------- */

/* Answers at fixed times, s, again and again at other parameters: what is known of the times is worked out
 * once. Options may be null, and cannot hold time. Null as samara_query_open_with(), and for a codebook
 * without time. */
samara_trajectory* samara_trajectory_open(const samara_codebook* book, size_t time_count, const double* times,
                                          const samara_options* options);
void samara_trajectory_close(samara_trajectory* trajectory);
/* Free coordinates but time. */
int samara_trajectory_parameter_count(const samara_trajectory* trajectory);
int samara_trajectory_output_count(const samara_trajectory* trajectory);
size_t samara_trajectory_time_count(const samara_trajectory* trajectory);

/* q has a number per parameter. values[output * times + time]; derivatives, or null where they are not
 * wanted: derivatives[(parameter * outputs + output) * times + time]. */
samara_status samara_trajectory_values(samara_trajectory* trajectory, const double* q, double* values,
                                       double* derivatives);
/* Many trajectories, one after the other; threads as in samara_batch(). */
samara_status samara_trajectory_batch(samara_trajectory* trajectory, size_t count, const double* points,
                                      double* values, double* derivatives, int threads);

#ifdef __cplusplus
}
#endif

#endif
