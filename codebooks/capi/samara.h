#ifndef SAMARA_CODEBOOKS_CAPI_SAMARA_H
#define SAMARA_CODEBOOKS_CAPI_SAMARA_H

#include <stddef.h>

/* Codebooks for other languages, through C: open, query, close. Link samara::c.
 *
 * Numbers are in SI units, angles in rad. No exception and no text leaves these functions: those that may
 * fail return a status, or a null pointer, and samara_error() says why in one sentence.
 *
 * A codebook may be shared between threads; a query holds scratch space, one per thread. Answers do not
 * allocate, except batches on several threads and the first one in a piece of a large file that was not read
 * yet.
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

/* What the last call in this thread that failed has to say; "" before. Valid until the next one. */
const char* samara_error(void);

/* Null if the file cannot be read. */
samara_codebook* samara_open(const char* path);
/* Its queries must be closed before. Null is ignored. */
void samara_close(samara_codebook* book);

int samara_coordinate_count(const samara_codebook* book);
int samara_output_count(const samara_codebook* book);
/* Names and units live as long as the codebook. Null for an index that does not exist. */
const char* samara_coordinate_name(const samara_codebook* book, int coordinate);
const char* samara_coordinate_unit(const samara_codebook* book, int coordinate);
const char* samara_output_name(const samara_codebook* book, int output);
const char* samara_output_unit(const samara_codebook* book, int output);
/* Ends of the box. */
samara_status samara_bounds(const samara_codebook* book, int coordinate, double* lower, double* upper);
/* 1 if the codebook has a certificate that it meets, else 0. */
int samara_is_certified(const samara_codebook* book);

/* Null if memory is short or a piece of the file is damaged. */
samara_query* samara_query_open(const samara_codebook* book);
void samara_query_close(samara_query* query);

/* All outputs at a point: x has a number per coordinate, values one per output. */
samara_status samara_values(samara_query* query, const double* x, double* values);
/* The same with derivatives: gradient[output * coordinates + coordinate]. */
samara_status samara_gradient(samara_query* query, const double* x, double* values, double* gradient);
/* Many points, one after the other; threads 0: as many as the machine has. */
samara_status samara_batch(samara_query* query, size_t count, const double* points, double* values,
                           int threads);

#ifdef __cplusplus
}
#endif

#endif
