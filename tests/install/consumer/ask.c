/* A user's program in C: opens the codebook that the other program saved, and asks it. */
#include <math.h>
#include <stdio.h>

#include <samara/codebooks/capi/samara.h>

int main(int argc, char** argv) {
  samara_codebook* book = samara_open(argc > 1 ? argv[1] : "");
  samara_query* query = book == NULL ? NULL : samara_query_open(book);
  const double point[] = {2.0, 0.5}; /* t, rate */
  double u = 0.0, slopes[2] = {0.0, 0.0};
  if (query == NULL || samara_gradient(query, point, &u, slopes) != SAMARA_DONE) {
    fprintf(stderr, "%s\n", samara_error());
    return 1;
  }
  printf("from C: u = %.15g, du/dt = %.15g\n", u, slopes[0]);
  samara_query_close(query);
  samara_close(book);
  return fabs(u - exp(1.0)) < 1e-8 && fabs(slopes[0] - 0.5 * exp(1.0)) < 1e-6 ? 0 : 1;
}
