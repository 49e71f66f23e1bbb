/* Falling bodies by pkg-config: an open that fails says why. */
#include <samara/motion/capi/samara_bodies.h>

int main(void) {
  return samara_motions_open("no_motions.h5") != NULL || samara_bodies_error()[0] == '\0';
}
