/* A thousand leaves fall to the ground, and nothing but their poses comes out:
 *
 *   samara sweep examples/leaves/leaf.toml -o sweep.h5
 *   samara database sweep.h5 -o leaf.h5
 *   leaves leaf.h5
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <samara/motion/capi/samara_bodies.h>

enum { kLeaves = 1000 };

static double positions[3 * kLeaves], rotations[4 * kLeaves];

static int complain(void) {
  fprintf(stderr, "leaves: %s\n", samara_bodies_error());
  return EXIT_FAILURE;
}

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "usage: leaves MOTIONS.h5\n");
    return EXIT_FAILURE;
  }
  /* 1. The motions of one leaf: falls of a sweep, cut at their events. */
  samara_motions* motions = samara_motions_open(argv[1]);
  if (motions == NULL) return complain();
  /* 2. Leaves that go on with what its chain of events draws, over ground at z = 0, in a light wind. */
  samara_bodies_options options = samara_bodies_defaults();
  options.step = 1.0 / 240.0;
  options.has_ground = 1;
  options.wind[0] = 0.5;
  options.seed = 7;
  samara_bodies* leaves = samara_bodies_open(motions, kLeaves, &options);
  if (leaves == NULL) return complain();
  for (size_t n = 0; n < kLeaves; ++n) {
    const double place[3] = {0.2 * (double)(n % 40), 0.2 * (double)(n / 40),
                             2.0 + 0.001 * (double)n};
    if (samara_bodies_release(leaves, n, place, 2.4 * (double)n) != SAMARA_BODIES_DONE)
      return complain();
  }
  /* 3. Frame by frame. */
  int frames = 0;
  while (samara_bodies_falling(leaves) > 0 && frames < 60 * 60) {
    if (samara_bodies_advance(leaves, 1.0 / 60.0) != SAMARA_BODIES_DONE) return complain();
    if (samara_bodies_poses(leaves, positions, rotations) != SAMARA_BODIES_DONE) return complain();
    ++frames;
  }
  size_t landed = 0;
  double drift = 0.0;
  for (size_t n = 0; n < kLeaves; ++n) {
    landed += samara_bodies_state(leaves, n) == SAMARA_BODY_LANDED;
    drift += (positions[3 * n] - 0.2 * (double)(n % 40)) / kLeaves;
  }
  printf("%zu of %d leaves landed within %.2f s, %.2f m down the wind on average\n", landed,
         kLeaves, frames / 60.0, drift);
  samara_bodies_close(leaves);
  samara_motions_close(motions);
  return landed == kLeaves ? EXIT_SUCCESS : EXIT_FAILURE;
}
