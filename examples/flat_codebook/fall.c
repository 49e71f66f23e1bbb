/* Asks a flat codebook; links the C library and libm only.
 *
 *   cc -std=c99 -O3 -march=native -I include fall.c -lm -o fall
 *   fall BOOK.flat                what it holds, and how far it is from the truth
 *   fall BOOK.flat 0.3 1.15 0.1   outputs at a point, coordinates in order, with derivatives by all of them
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAMARA_EVAL_IMPLEMENTATION
#include "samara/codebooks/capi/samara_eval.h"

/* A plain number has no unit to show. */
static void print_unit(const char* unit) {
  if (strcmp(unit, "1") != 0) printf(" [%s]", unit);
}

static void describe(const samara_eval* book) {
  const samara_eval_certificate certificate = samara_eval_certificate_of(book);
  int k, o;
  for (k = 0; k < samara_eval_coordinate_count(book); ++k) {
    double lower = 0.0, upper = 0.0;
    samara_eval_bounds(book, k, &lower, &upper);
    printf("coordinate %s from %g to %g", samara_eval_coordinate_name(book, k), lower, upper);
    print_unit(samara_eval_coordinate_unit(book, k));
    printf("\n");
  }
  for (o = 0; o < samara_eval_output_count(book); ++o) {
    double relative = 0.0, si = 0.0;
    samara_eval_output_error(book, o, &relative, &si);
    printf("output %s, error at most %.2g", samara_eval_output_name(book, o), si);
    print_unit(samara_eval_output_unit(book, o));
    printf("\n");
  }
  printf("tolerance %g %s at %g points\n", certificate.tolerance,
         certificate.met ? "met" : "NOT met", certificate.points);
}

static int ask(const samara_eval* book, char** numbers) {
  const int coordinates = samara_eval_coordinate_count(book),
            outputs = samara_eval_output_count(book);
  const size_t answers = (size_t)(coordinates + outputs + outputs * coordinates);
  double* const x = (double*)malloc(sizeof(double) * (answers + samara_eval_work_size(book)));
  double* const values = x + coordinates;
  double* const gradient = values + outputs;
  samara_eval_status status;
  int k, o;
  if (x == NULL) return SAMARA_EVAL_NO_MEMORY;
  for (k = 0; k < coordinates; ++k) x[k] = strtod(numbers[k], NULL);
  status = samara_eval_point(book, x + answers, x, values, gradient);
  if (status == SAMARA_EVAL_DONE) {
    for (o = 0; o < outputs; ++o) {
      printf("%s = %.10g", samara_eval_output_name(book, o), values[o]);
      for (k = 0; k < coordinates; ++k)
        printf("  d/d%s = %.6g", samara_eval_coordinate_name(book, k),
               gradient[o * coordinates + k]);
      printf("\n");
    }
  } else {
    k = samara_eval_outside(book, x);
    fprintf(stderr, "%s is outside\n", k < 0 ? "the point" : samara_eval_coordinate_name(book, k));
  }
  free(x);
  return (int)status;
}

int main(int argc, char** argv) {
  samara_eval* book = NULL;
  const char* why = "usage: fall BOOK.flat [COORDINATE ..]";
  int status = argc < 2 ? SAMARA_EVAL_WRONG_CALL : (int)samara_eval_open(argv[1], &book, &why);
  if (status != SAMARA_EVAL_DONE) {
    fprintf(stderr, "%s\n", why);
    return status;
  }
  if (argc == 2) {
    describe(book);
  } else if (argc == 2 + samara_eval_coordinate_count(book)) {
    status = ask(book, argv + 2);
  } else {
    fprintf(stderr, "%d coordinates, expected %d\n", argc - 2, samara_eval_coordinate_count(book));
    status = SAMARA_EVAL_WRONG_CALL;
  }
  samara_eval_close(book);
  return status;
}
