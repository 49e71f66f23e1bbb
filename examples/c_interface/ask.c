/* Asks a codebook from C.
 *
 *   ask BOOK.h5               what it holds, and how far that is from the truth
 *   ask BOOK.h5 0.3 1.15 0.1  outputs at a point, coordinates in order, with derivatives by all of them
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "samara/codebooks/capi/samara.h"

/* A plain number has no unit to show. */
static void print_unit(const char* unit) {
  if (strcmp(unit, "1") != 0) printf(" [%s]", unit);
}

static void describe(const samara_codebook* book) {
  for (int k = 0; k < samara_coordinate_count(book); ++k) {
    double lower, upper;
    samara_bounds(book, k, &lower, &upper);
    printf("coordinate %s from %g to %g", samara_coordinate_name(book, k), lower, upper);
    print_unit(samara_coordinate_unit(book, k));
    printf("\n");
  }
  for (int o = 0; o < samara_output_count(book); ++o) {
    printf("output %s", samara_output_name(book, o));
    print_unit(samara_output_unit(book, o));
    printf("\n");
  }
  for (int f = 0; f < samara_fixed_count(book); ++f) {
    double value = 0.0;
    samara_fixed_value(book, f, &value);
    printf("held %s = %g", samara_fixed_name(book, f), value);
    print_unit(samara_fixed_unit(book, f));
    printf("\n");
  }
  samara_certificate certificate;
  if (samara_certificate_of(book, &certificate) == SAMARA_DONE)
    printf("largest error %.2g of the range at %d points, tolerance %g %s\n", certificate.max_error,
           certificate.points, certificate.tolerance, certificate.met ? "met" : "NOT met");
}

static int ask(const samara_codebook* book, char** numbers) {
  const int coordinates = samara_coordinate_count(book), outputs = samara_output_count(book);
  double* x = malloc(sizeof(double) * (size_t)(coordinates + outputs * (1 + coordinates)));
  double* values = x + coordinates;
  double* gradient = values + outputs;
  for (int k = 0; k < coordinates; ++k) x[k] = strtod(numbers[k], NULL);
  samara_query* query = samara_query_open(book);
  const samara_status status =
      query == NULL ? SAMARA_INTERNAL : samara_gradient(query, x, values, gradient);
  if (status != SAMARA_DONE) {
    fprintf(stderr, "%s\n", samara_error());
  } else {
    for (int o = 0; o < outputs; ++o) {
      printf("%s = %.10g", samara_output_name(book, o), values[o]);
      for (int k = 0; k < coordinates; ++k)
        printf("  d/d%s = %.6g", samara_coordinate_name(book, k), gradient[o * coordinates + k]);
      printf("\n");
    }
  }
  samara_query_close(query);
  free(x);
  return (int)status;
}

int main(int argc, char** argv) {
  samara_codebook* book = argc < 2 ? NULL : samara_open(argv[1]);
  if (book == NULL) {
    fprintf(stderr, "%s\n", argc < 2 ? "usage: ask BOOK.h5 [COORDINATE ..]" : samara_error());
    return argc < 2 ? SAMARA_WRONG_CALL : SAMARA_BAD_FILE;
  }
  int status = SAMARA_DONE;
  if (argc == 2) {
    describe(book);
  } else if (argc == 2 + samara_coordinate_count(book)) {
    status = ask(book, argv + 2);
  } else {
    fprintf(stderr, "%d coordinates, expected %d\n", argc - 2, samara_coordinate_count(book));
    status = SAMARA_WRONG_CALL;
  }
  samara_close(book);
  return status;
}
