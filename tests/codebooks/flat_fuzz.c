/* Flat files that contradict themselves under a checksum that agrees, as nobody but an attacker makes them:
 * samara_eval.h refuses them, or answers from memory that is its own. Under the sanitizers anything else ends here.
 * It fails also where all were opened, or none: then it would have tested nothing.
 *
 *   flat_fuzz COUNT FILE ..   so many mutations of each file
 */
#define SAMARA_EVAL_IMPLEMENTATION
#include "samara/codebooks/capi/samara_eval.h"

/* xorshift64*, the same numbers everywhere. */
static uint64_t draw(uint64_t* state) {
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return *state * UINT64_C(2685821657736338717);
}

static void put_word(unsigned char* words, size_t at, uint64_t word) {
  memcpy(words + 8 * at, &word, 8);
}

/* Another word: one bit, a small number, one from elsewhere in the file, or any. */
static uint64_t other_word(const unsigned char* words, size_t count, uint64_t word, uint64_t* state) {
  const uint64_t kind = draw(state) % 5;
  if (kind == 0) return word ^ (UINT64_C(1) << draw(state) % 64);
  if (kind == 1) return draw(state) % 64;
  if (kind == 2) return samara_eval_word(words, draw(state) % count);
  if (kind == 3) return word + draw(state) % 17 - 8;
  return draw(state);
}

/* All corners of the box and its middle, with derivatives. */
static void answer(const samara_eval* book) {
  const size_t d = book->coordinates, outputs = book->outputs, corners = d < 10 ? (size_t)1 << d : 1024;
  double* const x = (double*)malloc(sizeof(double) * (d + outputs * (d + 1) + book->work_size));
  double* const values = x + d;
  size_t corner, k;
  if (x == NULL) return;
  for (corner = 0; corner <= corners; ++corner) {
    for (k = 0; k < d; ++k) {
      double lower = 0.0, upper = 0.0;
      samara_eval_bounds(book, (int)k, &lower, &upper);
      x[k] = corner == corners ? 0.5 * (lower + upper) : (corner >> k) % 2 == 0 ? lower : upper;
    }
    samara_eval_point(book, x + d + outputs * (d + 1), x, values, values + outputs);
    samara_eval_point(book, x + d + outputs * (d + 1), x, values, NULL);
  }
  free(x);
}

static int mutate(const unsigned char* bytes, size_t size, int count, uint64_t* state, int* opened) {
  unsigned char* const other = (unsigned char*)malloc(size);
  const size_t words = size / 8;
  int trial;
  if (other == NULL) return 0;
  for (trial = 0; trial < count; ++trial) {
    const uint64_t changes = 1 + draw(state) % 3;
    samara_eval* book = NULL;
    uint64_t change;
    memcpy(other, bytes, size);
    for (change = 0; change < changes; ++change) {
      /* Tables stand at the front and behind the numbers: half of all changes go into the header. */
      const size_t range = draw(state) % 2 == 0 ? SAMARA_EVAL_H_SIZE : words;
      const size_t at = 4 + draw(state) % (range - 4);
      put_word(other, at, other_word(other, words, samara_eval_word(other, at), state));
    }
    put_word(other, SAMARA_EVAL_H_CHECKSUM, samara_eval_checksum(other + 32, words - 4));
    if (samara_eval_open_memory(other, size, &book, NULL) != SAMARA_EVAL_DONE) continue;
    ++*opened;
    answer(book);
    samara_eval_close(book);
  }
  free(other);
  return 1;
}

/* A point that is not finite is refused, whatever the compiler was told of such numbers. */
static int refuses_nan(const samara_eval* book) {
  const size_t d = book->coordinates, outputs = book->outputs;
  double* const x = (double*)malloc(sizeof(double) * (d + outputs + book->work_size));
  const uint64_t words[2] = {UINT64_C(0x7ff8000000000000), UINT64_C(0x7ff0000000000000)};
  size_t k, w;
  int refused = x != NULL;
  for (k = 0; refused && k < d; ++k) {
    double lower = 0.0, upper = 0.0;
    samara_eval_bounds(book, (int)k, &lower, &upper);
    x[k] = lower;
  }
  for (k = 0; refused && k < d; ++k) {
    const double inside = x[k];
    for (w = 0; w < 2; ++w) {
      memcpy(x + k, words + w, 8);
      refused = refused && samara_eval_outside(book, x) == (int)k &&
                samara_eval_point(book, x + d + outputs, x, x + d, NULL) == SAMARA_EVAL_WRONG_CALL;
    }
    x[k] = inside;
  }
  free(x);
  return refused;
}

/* The size of a work space is bounded where size_t has 32 bits: by a sum of 2^16 terms over 32767 coordinates, and
 * by one less than what a book needs. */
static int bounds_work(const samara_eval* book) {
  const size_t most = UINT32_MAX / sizeof(double) / 2;
  samara_eval forged;
  memset(&forged, 0, sizeof forged);
  forged.coordinates = 32767;
  forged.weights_lead = forged.blend_lead = 8;
  forged.column_lead = 65544;
  return samara_eval_work_of(&forged, most) == most + 1 &&
         samara_eval_work_of(book, book->work_size) == book->work_size &&
         samara_eval_work_of(book, book->work_size - 1) == book->work_size;
}

/* Many pieces that are all the first one: reading them would take far longer than the size of the file says. */
static int refuses_overlaps(const samara_eval* book) {
  const size_t d = book->coordinates, pieces = 4096, old = (book->word_count + 7) / 8 * 8;
  const size_t groups = pieces * book->piece_list[0].group_count, table = old + 2 * d * pieces;
  /* As long as a file with so many groups is at least. */
  const size_t words = table + 3 * pieces + groups * d * SAMARA_EVAL_CORE_SIZE;
  const size_t old_table = samara_eval_count(book, SAMARA_EVAL_H_PIECE_TABLE);
  unsigned char* const other = (unsigned char*)calloc(words, 8);
  samara_eval* forged = NULL;
  size_t p, k;
  int refused;
  if (other == NULL) return 0;
  memcpy(other, book->words, 8 * book->word_count);
  for (p = 0; p < pieces; ++p) {
    memcpy(other + 8 * (old + 2 * d * p), book->boxes, 16 * d);
    for (k = 0; k < 3; ++k) put_word(other, table + 3 * p + k, samara_eval_word(other, old_table + k));
  }
  put_word(other, SAMARA_EVAL_H_WORDS, words);
  put_word(other, SAMARA_EVAL_H_PIECES, pieces);
  put_word(other, SAMARA_EVAL_H_GROUPS, groups);
  put_word(other, SAMARA_EVAL_H_BOXES, old);
  put_word(other, SAMARA_EVAL_H_PIECE_TABLE, table);
  put_word(other, SAMARA_EVAL_H_CHECKSUM, samara_eval_checksum(other + 32, words - 4));
  refused = samara_eval_open_memory(other, 8 * words, &forged, NULL) == SAMARA_EVAL_BAD_FILE;
  samara_eval_close(forged);
  free(other);
  return refused;
}

int main(int argc, char** argv) {
  uint64_t state = UINT64_C(20261123);
  int file, opened = 0;
  if (argc < 3 || atoi(argv[1]) < 1) {
    fputs("usage: flat_fuzz COUNT FILE ..\n", stderr);
    return 2;
  }
  for (file = 2; file < argc; ++file) {
    samara_eval* book = NULL;
    const char* why = "";
    if (samara_eval_open(argv[file], &book, &why) != SAMARA_EVAL_DONE) {
      fprintf(stderr, "%s: %s\n", argv[file], why);
      return 1;
    }
    answer(book);
    if (!refuses_nan(book) || !bounds_work(book) || !refuses_overlaps(book)) {
      fprintf(stderr,
              "%s: a point that is not finite (%d), a work space beyond all addresses (%d) or pieces that "
              "overlap (%d) were taken\n",
              argv[file], !refuses_nan(book), !bounds_work(book), !refuses_overlaps(book));
      return 1;
    }
    if (!mutate(book->words, 8 * book->word_count, atoi(argv[1]), &state, &opened)) return 1;
    samara_eval_close(book);
  }
  printf("%d mutations, of which %d were opened and answered\n", (argc - 2) * atoi(argv[1]), opened);
  /* Of a reader that takes or refuses everything nothing was tested. */
  return opened == 0 || opened == (argc - 2) * atoi(argv[1]);
}
