#ifndef SAMARA_MOTION_CAPI_SAMARA_BODIES_H
#define SAMARA_MOTION_CAPI_SAMARA_BODIES_H

#include <stddef.h>
#include <stdint.h>

/* Many falling bodies at run time, through C: a database of motions (samara database), and bodies that fall by it.
 * Link samara::motion_c (of pkg-config: samara-motion).
 *
 *   samara_motions* motions = samara_motions_open("leaf.h5");
 *   samara_bodies* leaves = samara_bodies_open(motions, 1000, NULL);
 *   for (size_t n = 0; n < 1000; ++n) samara_bodies_release(leaves, n, place[n], yaw[n]);
 *   each frame: samara_bodies_advance(leaves, 1.0 / 60.0); samara_bodies_poses(leaves, positions, rotations);
 *
 * SI units, world axes with z up. No exception and no text leaves these functions: those that may fail return a
 * status, or a null pointer, and samara_bodies_error() says why in one sentence. Nothing is allocated between opening
 * and closing but by releases. Motions may be shared between threads, bodies not.
 */

#ifdef __cplusplus
extern "C" {
#endif

/* The numbers of samara_status in samara.h. */
typedef enum samara_bodies_status {
  SAMARA_BODIES_DONE = 0,
  SAMARA_BODIES_INTERNAL = 1,
  SAMARA_BODIES_WRONG_CALL = 2,
  SAMARA_BODIES_BAD_FILE = 3
} samara_bodies_status;

typedef enum samara_body_state {
  SAMARA_BODY_FALLING = 0,
  SAMARA_BODY_LANDED = 1,     /* it rests where it met the ground */
  SAMARA_BODY_NOT_FINITE = 2, /* its states are no numbers any more; it rests where it was last */
  SAMARA_BODY_WAITING = 3     /* it was not released yet, or there is no such body */
} samara_body_state;

typedef struct samara_motions samara_motions;
typedef struct samara_bodies samara_bodies;

typedef struct samara_bodies_options {
  size_t size;    /* of this struct, sizeof(samara_bodies_options) */
  int by_graph;   /* 0: next pieces are drawn from the chain of kinds, else evenly from the graph */
  double step;    /* s, at most; 0: that of the database */
  double ramp;    /* s, in which coefficients change; below 0: a quarter of the median segment */
  int tries;      /* next pieces that are tried ahead at an event, 0 to 8: see bodies.h */
  int has_ground; /* else they fall for ever */
  double ground;  /* m, height */
  double wind[3]; /* m/s, steady; of models that have a sibling in gusts */
  uint64_t seed;
} samara_bodies_options;

/* What the last call in this thread that failed has to say; "" before. Valid until the next one. */
const char* samara_bodies_error(void);

/* Null if the file cannot be read. */
samara_motions* samara_motions_open(const char* path);
/* Bodies that fall by it must be closed before. Null is ignored. */
void samara_motions_close(samara_motions* motions);

/* Options with their defaults. */
samara_bodies_options samara_bodies_defaults(void);
/* Options null: defaults. Null if they mean nothing, or there are no bodies. */
samara_bodies* samara_bodies_open(const samara_motions* motions, size_t count,
                                  const samara_bodies_options* options);
void samara_bodies_close(samara_bodies* bodies);

/* Moving as if it had fallen for a while, its centre at x, y, z, turned about the vertical by `yaw`. A place that is
 * not above the ground is a wrong call, and changes nothing. */
samara_bodies_status samara_bodies_release(samara_bodies* bodies, size_t body, const double* place,
                                           double yaw);
samara_bodies_status samara_bodies_advance(samara_bodies* bodies, double dt);
/* 3 numbers a body: x, y, z; 4 a body: the quaternion w, x, y, z, body to world. */
samara_bodies_status samara_bodies_poses(const samara_bodies* bodies, double* positions, double* rotations);
samara_body_state samara_bodies_state(const samara_bodies* bodies, size_t body);
/* Bodies that fall. */
size_t samara_bodies_falling(const samara_bodies* bodies);

/* Of all events since the bodies were opened. */
typedef struct samara_bodies_counts {
  long events;
  long planned; /* that ended a segment for which a piece was chosen, steady ones left out .. */
  long kept;    /* .. and were of its kind */
  long drawn;   /* at which the chain drew a kind .. */
  long taken;   /* .. and a piece of it was taken .. */
  long redrawn; /* .. or of one that it drew then, among those that were left */
} samara_bodies_counts;

/* All zero of null. */
samara_bodies_counts samara_bodies_count(const samara_bodies* bodies);

#ifdef __cplusplus
}
#endif

#endif
