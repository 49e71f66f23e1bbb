#ifndef SAMARA_EVAL_H
#define SAMARA_EVAL_H

#include <stddef.h>

/* Codebooks of Samara in programs that link nothing but the C library and libm: one file of C99, or C++.
 *
 *   samara export coin.h5 --to flat -o coin.flat
 *
 * One source file of the program holds the code, all others leave the first line out:
 *
 *   #define SAMARA_EVAL_IMPLEMENTATION
 *   #include "samara_eval.h"
 *
 *   samara_eval* book = NULL;
 *   const char* why = "";
 *   if (samara_eval_open("coin.flat", &book, &why) != SAMARA_EVAL_DONE) { puts(why); return 1; }
 *   double* work = malloc(samara_eval_work_size(book) * sizeof *work);      one per thread
 *   const double x[3] = {0.3, 1.15, 0.1};                                   t, C_D, v(0), as the book has them
 *   double values[2], gradient[2 * 3];
 *   samara_eval_point(book, work, x, values, gradient);
 *
 * Values and gradients are those of the library, to round-off: of sums of products and trains, all bases and
 * transforms, slabs and cells; quaternions have the length with which they began. What a model derives from its
 * states (energies, forces) is not in a flat file, nor is anything that Samara would need to build on it.
 *
 * Numbers are doubles, in SI units, angles in rad. A book does not change once it is open: threads share it, each
 * with its own work space. Answers do not allocate. Compile with optimisation, and for the machine where that may be
 * (-O3 -march=native). Without that flag GCC and Clang for x86 make the inner loops also for processors with AVX2, and
 * the program looks which it runs on. Under -ffast-math files and points that hold NaN or infinity are refused as well.
 *
 * Before the line that includes the code, these may be defined:
 *   SAMARA_EVAL_STATIC        all functions are seen in that source file only
 *   SAMARA_EVAL_ONE_MACHINE   no instructions but those that the compiler was told of
 *   SAMARA_EVAL_PLAIN         plain loops of C, as for compilers that are neither GCC nor Clang
 *
 * A file that is damaged, cut off, from another format version or of another byte order is refused when it is
 * opened: every size and offset in it is checked, and a checksum over all of it.
 */

#ifdef __cplusplus
extern "C" {
#endif

#ifndef SAMARA_EVAL_STATIC
#define SAMARA_EVAL_API
#elif defined(__GNUC__)
#define SAMARA_EVAL_API static __attribute__((unused))
#else
#define SAMARA_EVAL_API static
#endif

/* The version of the flat format that this header reads. */
#define SAMARA_EVAL_FORMAT 1

typedef enum samara_eval_status {
  SAMARA_EVAL_DONE = 0,
  SAMARA_EVAL_NO_MEMORY = 1,
  SAMARA_EVAL_WRONG_CALL = 2, /* an argument that is null, or a coordinate that is not finite */
  SAMARA_EVAL_BAD_FILE = 3,   /* a file that is missing, damaged, or not a flat codebook */
  SAMARA_EVAL_OUTSIDE = 5     /* a point outside the box, or in a gap between pieces */
} samara_eval_status;

typedef struct samara_eval samara_eval;

/* `why` says in one sentence what is wrong; it may be null. Where a call fails, the book is null. */
SAMARA_EVAL_API samara_eval_status samara_eval_open(const char* path, samara_eval** book, const char** why);
/* The same of bytes in memory, which are copied. */
SAMARA_EVAL_API samara_eval_status samara_eval_open_memory(const void* bytes, size_t size, samara_eval** book,
                                                           const char** why);
/* Null is ignored. */
SAMARA_EVAL_API void samara_eval_close(samara_eval* book);

SAMARA_EVAL_API int samara_eval_coordinate_count(const samara_eval* book);
SAMARA_EVAL_API int samara_eval_output_count(const samara_eval* book);
/* Texts live as long as the book; they are empty for an index that does not exist. */
SAMARA_EVAL_API const char* samara_eval_coordinate_name(const samara_eval* book, int coordinate);
SAMARA_EVAL_API const char* samara_eval_coordinate_unit(const samara_eval* book, int coordinate);
SAMARA_EVAL_API const char* samara_eval_output_name(const samara_eval* book, int output);
SAMARA_EVAL_API const char* samara_eval_output_unit(const samara_eval* book, int output);
SAMARA_EVAL_API const char* samara_eval_model(const samara_eval* book);
SAMARA_EVAL_API const char* samara_eval_title(const samara_eval* book);
/* Ends of the box; WRONG_CALL for a coordinate that does not exist. */
SAMARA_EVAL_API samara_eval_status samara_eval_bounds(const samara_eval* book, int coordinate, double* lower,
                                                      double* upper);

/* Parameters and initial values that the plan fixed. */
SAMARA_EVAL_API int samara_eval_fixed_count(const samara_eval* book);
SAMARA_EVAL_API const char* samara_eval_fixed_name(const samara_eval* book, int fixed);
SAMARA_EVAL_API const char* samara_eval_fixed_unit(const samara_eval* book, int fixed);
/* NaN for an index that does not exist. */
SAMARA_EVAL_API double samara_eval_fixed_value(const samara_eval* book, int fixed);

typedef struct samara_eval_certificate {
  int exists;       /* 0: nobody measured the error, and the numbers are NaN */
  int met;          /* 1: the build converged, and no error exceeds the tolerance */
  double tolerance; /* of each output's range, as the plan has it */
  double max_error; /* the largest of all outputs, in the same measure */
  double points;    /* at which it was measured */
} samara_eval_certificate;
SAMARA_EVAL_API samara_eval_certificate samara_eval_certificate_of(const samara_eval* book);
/* Largest error of an output: of its range, and in its unit. NaN without a certificate. */
SAMARA_EVAL_API samara_eval_status samara_eval_output_error(const samara_eval* book, int output,
                                                            double* relative, double* si);

/* Doubles of the work space of one thread. */
SAMARA_EVAL_API size_t samara_eval_work_size(const samara_eval* book);

/* All outputs at a point x, which has a number per coordinate, and derivatives: gradient[output * coordinates +
 * coordinate], or null where they are not wanted. At a border of pieces the lower one answers. Derivatives by a
 * coordinate that is a list of values are NaN. A point that is refused leaves values and gradient as they are. */
SAMARA_EVAL_API samara_eval_status samara_eval_point(const samara_eval* book, double* work, const double* x,
                                                     double* values, double* gradient);
/* The first coordinate that is not finite or outside the box; -1 if all are inside. */
SAMARA_EVAL_API int samara_eval_outside(const samara_eval* book, const double* x);

#ifdef __cplusplus
}
#endif

#endif /* SAMARA_EVAL_H */

#if defined(SAMARA_EVAL_IMPLEMENTATION) && !defined(SAMARA_EVAL_IMPLEMENTED)
#define SAMARA_EVAL_IMPLEMENTED

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of rows are stored up to a multiple of this. */
#define SAMARA_EVAL_PAD 8
/* Doubles of a work space, whose size in bytes the caller works out, and adds some to. */
#define SAMARA_EVAL_MOST_WORK ((size_t)-1 / sizeof(double) / 2)
/* Products of more differences may leave the range of doubles. */
#define SAMARA_EVAL_MOST_PRODUCTS 64

enum { SAMARA_EVAL_ELEMENTS = 0, SAMARA_EVAL_PERIODIC = 1, SAMARA_EVAL_LIST = 2 };
enum { SAMARA_EVAL_NONE = 0, SAMARA_EVAL_LOG = 1, SAMARA_EVAL_RECIPROCAL = 2, SAMARA_EVAL_SQUARE_ROOT = 3 };

typedef struct samara_eval_axis {
  size_t kind, transform, touched, nodes, elements, lead;
  const double* places;    /* borders of elements; else the nodes */
  const double* distances; /* lengths of elements under the transform */
  const double* reference; /* nodes of an element on [-1, 1] */
  const double* lambda; /* per node j of an element, the product over others of 1 / (2 (node_j - node_k)) */
  const double* slopes; /* the differentiation matrix, row by row, `lead` apart */
  double lower, upper;
} samara_eval_axis;

typedef struct
    samara_eval_core { /* of a node: a matrix, column by column; of a sum, left = terms, right = 1 */
  size_t left, right, stride;
  const double* data;
} samara_eval_core;

typedef struct samara_eval_group {
  size_t is_train, outputs, first_output, front_rank, front_lead;
  const double* front; /* rows of outputs before the first core; null where it has them on its left side */
  const samara_eval_core* cores;
} samara_eval_group;

typedef struct samara_eval_piece {
  const double* box; /* lower and upper, coordinate by coordinate */
  const samara_eval_axis* axes;
  const samara_eval_group* groups;
  size_t group_count;
} samara_eval_piece;

struct samara_eval {
  void* memory;         /* of the file */
  unsigned char* words; /* in it, on a border of vectors */
  size_t word_count;
  const char* texts;
  size_t text_size;
  size_t coordinates, outputs, pieces, groups, fixed;
  size_t coordinate_table, output_table, fixed_table; /* words */
  const double* boxes;
  const double* borders; /* of pieces, on the first coordinate */
  size_t border_count, starts, candidates;
  size_t has_attitude, attitude[4];
  double attitude_length;
  samara_eval_axis* axis_list;
  samara_eval_core* core_list;
  samara_eval_group* group_list;
  samara_eval_piece* piece_list;
  size_t weights_lead, blend_lead, column_lead, work_size;
  size_t numbers_read; /* words of all arrays that were checked */
};

/* Reading ------------------------------------------------------------------------------------------------ */

/* Words of the header, docs/flat_file.md. */
enum {
  SAMARA_EVAL_H_MAGIC = 0,
  SAMARA_EVAL_H_VERSION = 1,
  SAMARA_EVAL_H_WORDS = 2,
  SAMARA_EVAL_H_CHECKSUM = 3,
  SAMARA_EVAL_H_COORDINATES = 4,
  SAMARA_EVAL_H_OUTPUTS = 5,
  SAMARA_EVAL_H_PIECES = 6,
  SAMARA_EVAL_H_GROUPS = 7,
  SAMARA_EVAL_H_FIXED = 8,
  SAMARA_EVAL_H_TEXTS = 9,
  SAMARA_EVAL_H_TEXT_WORDS = 10,
  SAMARA_EVAL_H_COORDINATE_TABLE = 11,
  SAMARA_EVAL_H_OUTPUT_TABLE = 12,
  SAMARA_EVAL_H_FIXED_TABLE = 13,
  SAMARA_EVAL_H_PIECE_TABLE = 14,
  SAMARA_EVAL_H_BOXES = 15,
  SAMARA_EVAL_H_BORDER_COUNT = 16,
  SAMARA_EVAL_H_BORDERS = 17,
  SAMARA_EVAL_H_STARTS = 18,
  SAMARA_EVAL_H_CANDIDATES = 19,
  SAMARA_EVAL_H_ATTITUDE = 20, /* 1 or 0, four places, the length */
  SAMARA_EVAL_H_MODEL = 26,
  SAMARA_EVAL_H_TITLE = 27,
  SAMARA_EVAL_H_CERTIFICATE = 28, /* exists, met, tolerance, largest error, points */
  SAMARA_EVAL_H_SIZE = 40,
  SAMARA_EVAL_AXIS_SIZE = 16,
  SAMARA_EVAL_GROUP_SIZE = 8,
  SAMARA_EVAL_CORE_SIZE = 4
};

static uint64_t samara_eval_word(const unsigned char* words, size_t at) {
  uint64_t word;
  memcpy(&word, words + 8 * at, 8);
  return word;
}

static double samara_eval_number(const unsigned char* words, size_t at) {
  double number;
  memcpy(&number, words + 8 * at, 8);
  return number;
}

/* A word that counts something; more than the words of the file if it is more than any number could be. */
static size_t samara_eval_count(const samara_eval* book, size_t at) {
  const uint64_t word = samara_eval_word(book->words, at);
  return word > book->word_count ? book->word_count + 1 : (size_t)word;
}

/* Whether count items of `each` words stand at an offset. */
static int samara_eval_has(const samara_eval* book, size_t offset, size_t count, size_t each) {
  if (offset > book->word_count) return 0;
  return each == 0 || count <= (book->word_count - offset) / each;
}

/* Whether a number is neither infinite nor NaN: by its bits, since compilers that are told of finite numbers only
 * (-ffast-math) take isfinite() away. */
static int samara_eval_is_finite(double number) {
  uint64_t word;
  memcpy(&word, &number, 8);
  return ((word >> 52) & 0x7ff) != 0x7ff;
}

/* Finite numbers at the offset that word `at` holds; null if they are not there. Arrays of a sound file do not
 * overlap: one whose arrays have more words than it has itself is forged, and would take long to read. */
static const double* samara_eval_numbers(samara_eval* book, size_t at, size_t count, size_t each) {
  const size_t offset = samara_eval_count(book, at);
  const double* numbers;
  size_t i;
  if (!samara_eval_has(book, offset, count, each)) return NULL;
  if (count * each > book->word_count - book->numbers_read) return NULL;
  book->numbers_read += count * each;
  numbers = (const double*)(const void*)(book->words + 8 * offset);
  for (i = 0; i < count * each; ++i)
    if (!samara_eval_is_finite(numbers[i])) return NULL;
  return numbers;
}

static int samara_eval_ascends(const double* numbers, size_t count, size_t step) {
  size_t i;
  for (i = 1; i < count; ++i)
    if (!(numbers[(i - 1) * step] < numbers[i * step])) return 0;
  return 1;
}

static int samara_eval_is_text(const samara_eval* book, size_t at) {
  return samara_eval_word(book->words, at) < book->text_size;
}

static const char* samara_eval_text(const samara_eval* book, size_t at) {
  return book->texts + samara_eval_word(book->words, at);
}

/* Each word changes all that follow: one that is wrong is always found. */
static uint64_t samara_eval_checksum(const unsigned char* words, size_t count) {
  uint64_t sum = UINT64_C(0xcbf29ce484222325);
  size_t i;
  for (i = 0; i < count; ++i) {
    sum ^= samara_eval_word(words, i);
    sum = ((sum << 29) | (sum >> 35)) * UINT64_C(0x100000001b3);
  }
  return sum;
}

static size_t samara_eval_padded(size_t count) {
  return (count + SAMARA_EVAL_PAD - 1) / SAMARA_EVAL_PAD * SAMARA_EVAL_PAD;
}

static int samara_eval_read_axis(samara_eval* book, size_t at, samara_eval_axis* axis) {
  if (!samara_eval_has(book, at, SAMARA_EVAL_AXIS_SIZE, 1)) return 0;
  axis->kind = samara_eval_count(book, at);
  axis->transform = samara_eval_count(book, at + 1);
  axis->touched = samara_eval_count(book, at + 2);
  axis->nodes = samara_eval_count(book, at + 3);
  axis->elements = samara_eval_count(book, at + 4);
  axis->lead = samara_eval_count(book, at + 5);
  axis->lower = samara_eval_number(book->words, at + 6);
  axis->upper = samara_eval_number(book->words, at + 7);
  axis->distances = axis->reference = axis->lambda = axis->slopes = NULL;
  if (!samara_eval_is_finite(axis->lower) || !samara_eval_is_finite(axis->upper) || axis->lower > axis->upper)
    return 0;
  if (axis->nodes == 0 || axis->nodes > book->word_count || axis->transform > SAMARA_EVAL_SQUARE_ROOT)
    return 0;
  if (axis->kind == SAMARA_EVAL_LIST) {
    axis->places = samara_eval_numbers(book, at + 8, axis->nodes, 1);
    return axis->places != NULL && axis->touched == 1 && samara_eval_ascends(axis->places, axis->nodes, 1);
  }
  if (axis->touched < 2 || axis->touched > axis->nodes || axis->lead != samara_eval_padded(axis->touched))
    return 0;
  axis->slopes = samara_eval_numbers(book, at + 12, axis->touched, axis->lead);
  if (axis->slopes == NULL) return 0;
  if (axis->kind == SAMARA_EVAL_PERIODIC) {
    axis->places = samara_eval_numbers(book, at + 8, axis->nodes, 1);
    return axis->places != NULL && axis->touched == axis->nodes && axis->lower < axis->upper &&
           samara_eval_ascends(axis->places, axis->nodes, 1);
  }
  if (axis->kind != SAMARA_EVAL_ELEMENTS || axis->elements == 0 || axis->elements > axis->nodes) return 0;
  if ((axis->nodes - 1) / axis->elements != axis->touched - 1 || (axis->nodes - 1) % axis->elements != 0)
    return 0;
  axis->places = samara_eval_numbers(book, at + 8, axis->elements + 1, 1);
  axis->distances = samara_eval_numbers(book, at + 9, axis->elements, 1);
  axis->reference = samara_eval_numbers(book, at + 10, axis->touched, 1);
  axis->lambda = samara_eval_numbers(book, at + 11, axis->touched, 1);
  return axis->places != NULL && axis->distances != NULL && axis->reference != NULL && axis->lambda != NULL &&
         samara_eval_ascends(axis->places, axis->elements + 1, 1) &&
         samara_eval_ascends(axis->reference, axis->touched, 1);
}

/* A group with its cores, which fit to each other and to the axes of the piece. */
static int samara_eval_read_group(samara_eval* book, size_t at, const samara_eval_axis* axes,
                                  size_t first_output, samara_eval_core* cores, samara_eval_group* group) {
  const size_t d = book->coordinates;
  size_t k, left;
  if (!samara_eval_has(book, at, SAMARA_EVAL_GROUP_SIZE, 1) ||
      !samara_eval_has(book, at + SAMARA_EVAL_GROUP_SIZE, d, SAMARA_EVAL_CORE_SIZE))
    return 0;
  group->is_train = samara_eval_count(book, at);
  group->outputs = samara_eval_count(book, at + 1);
  group->first_output = first_output;
  group->front_rank = samara_eval_count(book, at + 3);
  group->front_lead = samara_eval_count(book, at + 4);
  group->front = NULL;
  group->cores = cores;
  if (group->is_train > 1 || group->outputs > book->outputs - first_output) return 0;
  if (samara_eval_count(book, at + 2) == 1) {
    if (group->front_lead != samara_eval_padded(group->outputs) || group->front_rank > book->word_count)
      return 0;
    group->front = samara_eval_numbers(book, at + 5, group->front_rank, group->front_lead);
    if (group->front == NULL) return 0;
    if (book->column_lead < group->front_lead) book->column_lead = group->front_lead;
  } else if (samara_eval_count(book, at + 2) != 0 || !group->is_train) {
    return 0;
  }
  left = group->front != NULL ? group->front_rank : group->outputs;
  for (k = 0; k < d; ++k) {
    const size_t core_at = at + SAMARA_EVAL_GROUP_SIZE + k * SAMARA_EVAL_CORE_SIZE;
    samara_eval_core* core = cores + k;
    core->left = samara_eval_count(book, core_at);
    core->right = samara_eval_count(book, core_at + 1);
    core->stride = samara_eval_count(book, core_at + 2);
    if (core->left != left || core->stride > book->word_count) return 0;
    if (core->right == 0 || core->right > book->word_count || core->left > book->word_count / core->right)
      return 0;
    if (core->stride != samara_eval_padded(core->left * core->right)) return 0;
    core->data = samara_eval_numbers(book, core_at + 3, axes[k].nodes, core->stride);
    if (core->data == NULL) return 0;
    if (group->is_train) left = core->right;
    if ((!group->is_train || k + 1 == d) && core->right != 1) return 0;
    if (book->blend_lead < core->stride) book->blend_lead = core->stride;
    if (book->column_lead < samara_eval_padded(core->left))
      book->column_lead = samara_eval_padded(core->left);
  }
  return 1;
}

static int samara_eval_read_pieces(samara_eval* book) {
  const size_t d = book->coordinates;
  const size_t table = samara_eval_count(book, SAMARA_EVAL_H_PIECE_TABLE);
  size_t p, k, g, next_group = 0;
  if (!samara_eval_has(book, table, book->pieces, 3)) return 0;
  for (p = 0; p < book->pieces; ++p) {
    samara_eval_piece* piece = book->piece_list + p;
    samara_eval_axis* axes = book->axis_list + p * d;
    size_t axis_at = samara_eval_count(book, table + 3 * p);
    size_t group_at = samara_eval_count(book, table + 3 * p + 1);
    size_t outputs = 0;
    piece->box = book->boxes + 2 * p * d;
    piece->axes = axes;
    piece->groups = book->group_list + next_group;
    piece->group_count = samara_eval_count(book, table + 3 * p + 2);
    if (piece->group_count > book->groups - next_group) return 0;
    for (k = 0; k < d; ++k, axis_at += SAMARA_EVAL_AXIS_SIZE) {
      if (!samara_eval_read_axis(book, axis_at, axes + k)) return 0;
      if (piece->box[2 * k] > piece->box[2 * k + 1]) return 0;
      if (book->weights_lead < samara_eval_padded(axes[k].touched))
        book->weights_lead = samara_eval_padded(axes[k].touched);
    }
    for (g = 0; g < piece->group_count; ++g, ++next_group) {
      samara_eval_group* group = book->group_list + next_group;
      if (!samara_eval_read_group(book, group_at, axes, outputs, book->core_list + next_group * d, group))
        return 0;
      outputs += group->outputs;
      group_at += SAMARA_EVAL_GROUP_SIZE + d * SAMARA_EVAL_CORE_SIZE;
    }
    if (outputs != book->outputs) return 0;
  }
  return next_group == book->groups;
}

/* Which pieces a place on the first coordinate may belong to. */
static int samara_eval_read_finder(samara_eval* book) {
  size_t i, start = 0;
  book->border_count = samara_eval_count(book, SAMARA_EVAL_H_BORDER_COUNT);
  book->starts = samara_eval_count(book, SAMARA_EVAL_H_STARTS);
  book->candidates = samara_eval_count(book, SAMARA_EVAL_H_CANDIDATES);
  book->borders = samara_eval_numbers(book, SAMARA_EVAL_H_BORDERS, book->border_count, 1);
  if (book->borders == NULL || !samara_eval_ascends(book->borders, book->border_count, 1)) return 0;
  if (!samara_eval_has(book, book->starts, book->border_count, 1) || book->starts >= book->word_count)
    return 0;
  if (!samara_eval_has(book, book->starts, 1, book->border_count + 1)) return 0;
  for (i = 0; i <= book->border_count; ++i) {
    const size_t next = samara_eval_count(book, book->starts + i);
    if (next < start || (i == 0 && next != 0)) return 0;
    start = next;
  }
  if (!samara_eval_has(book, book->candidates, start, 1)) return 0;
  for (i = 0; i < start; ++i)
    if (samara_eval_count(book, book->candidates + i) >= book->pieces) return 0;
  return 1;
}

static int samara_eval_read_tables(samara_eval* book) {
  const size_t text_words = samara_eval_count(book, SAMARA_EVAL_H_TEXT_WORDS);
  const size_t texts = samara_eval_count(book, SAMARA_EVAL_H_TEXTS);
  size_t i;
  if (text_words == 0 || !samara_eval_has(book, texts, text_words, 1)) return 0;
  book->texts = (const char*)(book->words + 8 * texts);
  book->text_size = 8 * text_words;
  if (book->texts[book->text_size - 1] != '\0') return 0;
  book->coordinate_table = samara_eval_count(book, SAMARA_EVAL_H_COORDINATE_TABLE);
  book->output_table = samara_eval_count(book, SAMARA_EVAL_H_OUTPUT_TABLE);
  book->fixed_table = samara_eval_count(book, SAMARA_EVAL_H_FIXED_TABLE);
  if (!samara_eval_has(book, book->coordinate_table, book->coordinates, 4) ||
      !samara_eval_has(book, book->output_table, book->outputs, 4) ||
      !samara_eval_has(book, book->fixed_table, book->fixed, 3))
    return 0;
  for (i = 0; i < 2 * book->coordinates; ++i)
    if (!samara_eval_is_text(book, book->coordinate_table + i / 2 * 4 + i % 2)) return 0;
  for (i = 0; i < 2 * book->outputs; ++i)
    if (!samara_eval_is_text(book, book->output_table + i / 2 * 4 + i % 2)) return 0;
  for (i = 0; i < 2 * book->fixed; ++i)
    if (!samara_eval_is_text(book, book->fixed_table + i / 2 * 3 + i % 2)) return 0;
  if (!samara_eval_is_text(book, SAMARA_EVAL_H_MODEL) || !samara_eval_is_text(book, SAMARA_EVAL_H_TITLE))
    return 0;
  book->has_attitude = samara_eval_count(book, SAMARA_EVAL_H_ATTITUDE);
  book->attitude_length = samara_eval_number(book->words, SAMARA_EVAL_H_ATTITUDE + 5);
  if (book->has_attitude > 1) return 0;
  for (i = 0; i < 4; ++i) {
    book->attitude[i] = samara_eval_count(book, SAMARA_EVAL_H_ATTITUDE + 1 + i);
    if (book->has_attitude && book->attitude[i] >= book->outputs) return 0;
  }
  return !book->has_attitude || (samara_eval_is_finite(book->attitude_length) && book->attitude_length > 0.0);
}

/* a + b * c, or `most` + 1 where that is more than `most`; a may be that already. */
static size_t samara_eval_sum_up(size_t a, size_t b, size_t c, size_t most) {
  if (a > most || (c != 0 && b > (most - a) / c)) return most + 1;
  return a + b * c;
}

/* Doubles of a work space: first nodes; weights and slopes of all axes; two blends; two lists of columns; room to
 * align. `most` + 1 where they are more than `most`, as in a forged file where size_t has 32 bits. */
static size_t samara_eval_work_of(const samara_eval* book, size_t most) {
  const size_t d = book->coordinates;
  size_t size = samara_eval_padded(d) + 2 * SAMARA_EVAL_PAD;
  size = samara_eval_sum_up(size, book->weights_lead, 2 * d, most);
  size = samara_eval_sum_up(size, book->blend_lead, 2, most);
  return samara_eval_sum_up(size, book->column_lead, 2 * (d + 1), most);
}

/* Null, or what is wrong with the words of a file. */
static const char* samara_eval_read(samara_eval* book) {
  const char* const contradiction = "the file contradicts itself: it is damaged";
  const unsigned char* const words = book->words;
  size_t d;
  if (book->word_count < SAMARA_EVAL_H_SIZE) return "the file is too short for a flat codebook";
  if (memcmp(words, "SAMFLAT", 8) != 0)
    return "the file is not a flat codebook; samara export BOOK --to flat makes one";
  if ((samara_eval_word(words, SAMARA_EVAL_H_VERSION) & UINT64_C(0xffffffff)) != UINT64_C(0x01020304))
    return "the file is for machines of the other byte order";
  if (samara_eval_word(words, SAMARA_EVAL_H_VERSION) >> 32 != SAMARA_EVAL_FORMAT)
    return "the file has another version of the flat format than this program reads";
  if (samara_eval_word(words, SAMARA_EVAL_H_WORDS) != book->word_count)
    return "the file has another size than it says: it is cut off";
  if (samara_eval_word(words, SAMARA_EVAL_H_CHECKSUM) !=
      samara_eval_checksum(words + 8 * (SAMARA_EVAL_H_CHECKSUM + 1),
                           book->word_count - SAMARA_EVAL_H_CHECKSUM - 1))
    return "the file does not agree with its checksum: it is damaged";
  book->coordinates = d = samara_eval_count(book, SAMARA_EVAL_H_COORDINATES);
  book->outputs = samara_eval_count(book, SAMARA_EVAL_H_OUTPUTS);
  book->pieces = samara_eval_count(book, SAMARA_EVAL_H_PIECES);
  book->groups = samara_eval_count(book, SAMARA_EVAL_H_GROUPS);
  book->fixed = samara_eval_count(book, SAMARA_EVAL_H_FIXED);
  /* Each has words of its own, so that no product of these sizes overflows below. */
  if (d == 0 || d > 32767 || book->outputs > 32767 || book->fixed > 32767 || book->pieces == 0 ||
      book->pieces > book->word_count / (2 * d) ||
      book->groups > book->word_count / (d * SAMARA_EVAL_CORE_SIZE))
    return contradiction;
  if (!samara_eval_read_tables(book)) return contradiction;
  book->boxes = samara_eval_numbers(book, SAMARA_EVAL_H_BOXES, book->pieces, 2 * d);
  if (book->boxes == NULL || !samara_eval_read_finder(book)) return contradiction;
  book->axis_list = (samara_eval_axis*)calloc(book->pieces * d, sizeof(samara_eval_axis));
  book->piece_list = (samara_eval_piece*)calloc(book->pieces, sizeof(samara_eval_piece));
  book->group_list = (samara_eval_group*)calloc(book->groups + 1, sizeof(samara_eval_group));
  book->core_list = (samara_eval_core*)calloc((book->groups + 1) * d, sizeof(samara_eval_core));
  if (!book->axis_list || !book->piece_list || !book->group_list || !book->core_list)
    return "memory is short";
  if (!samara_eval_read_pieces(book)) return contradiction;
  book->column_lead += SAMARA_EVAL_PAD;
  book->blend_lead += SAMARA_EVAL_PAD;
  book->work_size = samara_eval_work_of(book, SAMARA_EVAL_MOST_WORK);
  return book->work_size > SAMARA_EVAL_MOST_WORK ? "the file asks for more memory than there are addresses"
                                                 : NULL;
}

/* Room for a file, on a border of vectors. */
static samara_eval* samara_eval_make(size_t size) {
  samara_eval* book = (samara_eval*)calloc(1, sizeof(samara_eval));
  if (book == NULL) return NULL;
  book->memory = size > (size_t)-1 - 64 ? NULL : malloc(size + 64);
  if (book->memory == NULL) {
    free(book);
    return NULL;
  }
  book->words = (unsigned char*)book->memory + (64 - (uintptr_t)book->memory % 64) % 64;
  book->word_count = size / 8;
  return book;
}

static samara_eval_status samara_eval_fail(samara_eval* book, samara_eval_status status, const char* sentence,
                                           const char** why) {
  samara_eval_close(book);
  if (why != NULL) *why = sentence;
  return status;
}

/* Of a book whose bytes are there. */
static samara_eval_status samara_eval_finish(samara_eval* made, size_t size, samara_eval** book,
                                             const char** why) {
  const char* const complaint =
      size % 8 != 0 ? "the file is no whole number of words: it is cut off, or no flat codebook"
                    : samara_eval_read(made);
  if (complaint != NULL) {
    const int is_short = strcmp(complaint, "memory is short") == 0;
    return samara_eval_fail(made, is_short ? SAMARA_EVAL_NO_MEMORY : SAMARA_EVAL_BAD_FILE, complaint, why);
  }
  *book = made;
  if (why != NULL) *why = "";
  return SAMARA_EVAL_DONE;
}

samara_eval_status samara_eval_open_memory(const void* bytes, size_t size, samara_eval** book,
                                           const char** why) {
  samara_eval* made;
  if (book != NULL) *book = NULL;
  if (bytes == NULL || book == NULL)
    return samara_eval_fail(NULL, SAMARA_EVAL_WRONG_CALL, "no bytes were given, or no place for the book",
                            why);
  made = samara_eval_make(size);
  if (made == NULL) return samara_eval_fail(NULL, SAMARA_EVAL_NO_MEMORY, "memory is short", why);
  memcpy(made->words, bytes, size);
  return samara_eval_finish(made, size, book, why);
}

samara_eval_status samara_eval_open(const char* path, samara_eval** book, const char** why) {
  samara_eval* made = NULL;
  FILE* file;
  long size = -1;
  if (book != NULL) *book = NULL;
  if (path == NULL || book == NULL)
    return samara_eval_fail(NULL, SAMARA_EVAL_WRONG_CALL, "no path was given, or no place for the book", why);
  file = fopen(path, "rb");
  if (file == NULL) return samara_eval_fail(NULL, SAMARA_EVAL_BAD_FILE, "the file cannot be opened", why);
  if (fseek(file, 0, SEEK_END) == 0) size = ftell(file);
  if (size >= 0 && size < LONG_MAX && fseek(file, 0, SEEK_SET) == 0) made = samara_eval_make((size_t)size);
  if (made == NULL) {
    fclose(file);
    return samara_eval_fail(NULL, size < 0 || size == LONG_MAX ? SAMARA_EVAL_BAD_FILE : SAMARA_EVAL_NO_MEMORY,
                            "the file cannot be read, or memory is short", why);
  }
  if (fread(made->words, 1, (size_t)size, file) != (size_t)size) {
    fclose(file);
    return samara_eval_fail(made, SAMARA_EVAL_BAD_FILE, "the file cannot be read", why);
  }
  fclose(file);
  return samara_eval_finish(made, (size_t)size, book, why);
}

void samara_eval_close(samara_eval* book) {
  if (book == NULL) return;
  free(book->axis_list);
  free(book->core_list);
  free(book->group_list);
  free(book->piece_list);
  free(book->memory);
  free(book);
}

/* What a book holds -------------------------------------------------------------------------------------- */

static const char* samara_eval_entry(const samara_eval* book, size_t table, size_t count, size_t each,
                                     int index, size_t column) {
  if (index < 0 || (size_t)index >= count) return "";
  return samara_eval_text(book, table + each * (size_t)index + column);
}

int samara_eval_coordinate_count(const samara_eval* book) {
  return book == NULL ? 0 : (int)book->coordinates;
}
int samara_eval_output_count(const samara_eval* book) {
  return book == NULL ? 0 : (int)book->outputs;
}
int samara_eval_fixed_count(const samara_eval* book) {
  return book == NULL ? 0 : (int)book->fixed;
}
const char* samara_eval_coordinate_name(const samara_eval* book, int k) {
  return book == NULL ? "" : samara_eval_entry(book, book->coordinate_table, book->coordinates, 4, k, 0);
}
const char* samara_eval_coordinate_unit(const samara_eval* book, int k) {
  return book == NULL ? "" : samara_eval_entry(book, book->coordinate_table, book->coordinates, 4, k, 1);
}
const char* samara_eval_output_name(const samara_eval* book, int o) {
  return book == NULL ? "" : samara_eval_entry(book, book->output_table, book->outputs, 4, o, 0);
}
const char* samara_eval_output_unit(const samara_eval* book, int o) {
  return book == NULL ? "" : samara_eval_entry(book, book->output_table, book->outputs, 4, o, 1);
}
const char* samara_eval_fixed_name(const samara_eval* book, int f) {
  return book == NULL ? "" : samara_eval_entry(book, book->fixed_table, book->fixed, 3, f, 0);
}
const char* samara_eval_fixed_unit(const samara_eval* book, int f) {
  return book == NULL ? "" : samara_eval_entry(book, book->fixed_table, book->fixed, 3, f, 1);
}
double samara_eval_fixed_value(const samara_eval* book, int f) {
  if (book == NULL || f < 0 || (size_t)f >= book->fixed) return (double)NAN;
  return samara_eval_number(book->words, book->fixed_table + 3 * (size_t)f + 2);
}
const char* samara_eval_model(const samara_eval* book) {
  return book == NULL ? "" : samara_eval_text(book, SAMARA_EVAL_H_MODEL);
}
const char* samara_eval_title(const samara_eval* book) {
  return book == NULL ? "" : samara_eval_text(book, SAMARA_EVAL_H_TITLE);
}

samara_eval_status samara_eval_bounds(const samara_eval* book, int k, double* lower, double* upper) {
  if (book == NULL || k < 0 || (size_t)k >= book->coordinates || lower == NULL || upper == NULL)
    return SAMARA_EVAL_WRONG_CALL;
  *lower = samara_eval_number(book->words, book->coordinate_table + 4 * (size_t)k + 2);
  *upper = samara_eval_number(book->words, book->coordinate_table + 4 * (size_t)k + 3);
  return SAMARA_EVAL_DONE;
}

samara_eval_certificate samara_eval_certificate_of(const samara_eval* book) {
  samara_eval_certificate none = {0, 0, 0.0, 0.0, 0.0};
  none.tolerance = none.max_error = none.points = (double)NAN;
  if (book == NULL || samara_eval_word(book->words, SAMARA_EVAL_H_CERTIFICATE) != 1) return none;
  none.exists = 1;
  none.met = samara_eval_word(book->words, SAMARA_EVAL_H_CERTIFICATE + 1) == 1;
  none.tolerance = samara_eval_number(book->words, SAMARA_EVAL_H_CERTIFICATE + 2);
  none.max_error = samara_eval_number(book->words, SAMARA_EVAL_H_CERTIFICATE + 3);
  none.points = samara_eval_number(book->words, SAMARA_EVAL_H_CERTIFICATE + 4);
  return none;
}

samara_eval_status samara_eval_output_error(const samara_eval* book, int o, double* relative, double* si) {
  if (book == NULL || o < 0 || (size_t)o >= book->outputs || relative == NULL || si == NULL)
    return SAMARA_EVAL_WRONG_CALL;
  *relative = samara_eval_number(book->words, book->output_table + 4 * (size_t)o + 2);
  *si = samara_eval_number(book->words, book->output_table + 4 * (size_t)o + 3);
  return SAMARA_EVAL_DONE;
}

size_t samara_eval_work_size(const samara_eval* book) {
  return book == NULL ? 0 : book->work_size;
}

/* Interpolation on an axis ------------------------------------------------------------------------------- */

/* The first of `count` ascending numbers that is not below x; `count` if all are. */
static size_t samara_eval_lower_bound(const double* numbers, size_t count, double x) {
  size_t low = 0;
  while (count > 0) {
    const size_t half = count / 2;
    if (numbers[low + half] < x) {
      low += half + 1;
      count -= half + 1;
    } else {
      count = half;
    }
  }
  return low;
}

/* T(x) - T(a), without the difference of two values of T. */
static double samara_eval_distance(size_t transform, double a, double x) {
  switch (transform) {
    case SAMARA_EVAL_LOG:
      return log1p((x - a) / a);
    case SAMARA_EVAL_RECIPROCAL:
      return (x - a) / a / x;
    case SAMARA_EVAL_SQUARE_ROOT:
      return x == a ? 0.0 : (x - a) / (sqrt(x) + sqrt(a));
    default:
      return x - a;
  }
}

static double samara_eval_transform_slope(size_t transform, double x) {
  switch (transform) {
    case SAMARA_EVAL_LOG:
      return 1.0 / x;
    case SAMARA_EVAL_RECIPROCAL:
      return 1.0 / x / x;
    case SAMARA_EVAL_SQUARE_ROOT:
      return 0.5 / sqrt(x);
    default:
      return 1.0;
  }
}

/* combine(columns, lead, rows, count, weights, out): out = sum over k < count of weights[k] times column k, of a matrix
 * column by column, `lead` apart. A core at a point from what it has at the nodes, or a matrix times a vector: all the
 * work of a point. Whole blocks of SAMARA_EVAL_PAD rows, for which there is room. */
typedef void (*samara_eval_combine)(const double*, size_t, size_t, size_t, const double*, double*);

#if defined(__GNUC__) && !defined(SAMARA_EVAL_PLAIN)
/* By vectors of so many bytes: four of them at a time, then one at a time, in sums that do not wait for each other. */
#define SAMARA_EVAL_COMBINE(name, bytes, machine)                                                          \
  typedef double name##_lanes __attribute__((vector_size(bytes), aligned(8), may_alias));                  \
  machine static void name(const double* columns, size_t lead, size_t rows, size_t count,                  \
                           const double* weights, double* out) {                                           \
    const name##_lanes zero = {0};                                                                         \
    const size_t each = (bytes) / sizeof(double), end = samara_eval_padded(rows);                          \
    size_t row = 0, k;                                                                                     \
    for (; row + 4 * each <= end; row += 4 * each) {                                                       \
      const double* from = columns + row;                                                                  \
      name##_lanes s0 = zero, s1 = zero, s2 = zero, s3 = zero, t0 = zero, t1 = zero, t2 = zero, t3 = zero; \
      for (k = 0; k + 2 <= count; k += 2, from += 2 * lead) {                                              \
        const name##_lanes* const a = (const name##_lanes*)(const void*)from;                              \
        const name##_lanes* const b = (const name##_lanes*)(const void*)(from + lead);                     \
        s0 += a[0] * weights[k];                                                                           \
        s1 += a[1] * weights[k];                                                                           \
        s2 += a[2] * weights[k];                                                                           \
        s3 += a[3] * weights[k];                                                                           \
        t0 += b[0] * weights[k + 1];                                                                       \
        t1 += b[1] * weights[k + 1];                                                                       \
        t2 += b[2] * weights[k + 1];                                                                       \
        t3 += b[3] * weights[k + 1];                                                                       \
      }                                                                                                    \
      if (k < count) {                                                                                     \
        const name##_lanes* const a = (const name##_lanes*)(const void*)from;                              \
        s0 += a[0] * weights[k];                                                                           \
        s1 += a[1] * weights[k];                                                                           \
        s2 += a[2] * weights[k];                                                                           \
        s3 += a[3] * weights[k];                                                                           \
      }                                                                                                    \
      ((name##_lanes*)(void*)(out + row))[0] = s0 + t0;                                                    \
      ((name##_lanes*)(void*)(out + row))[1] = s1 + t1;                                                    \
      ((name##_lanes*)(void*)(out + row))[2] = s2 + t2;                                                    \
      ((name##_lanes*)(void*)(out + row))[3] = s3 + t3;                                                    \
    }                                                                                                      \
    for (; row < end; row += each) {                                                                       \
      const double* from = columns + row;                                                                  \
      name##_lanes s0 = zero, s1 = zero, s2 = zero, s3 = zero;                                             \
      for (k = 0; k + 4 <= count; k += 4, from += 4 * lead) {                                              \
        s0 += *(const name##_lanes*)(const void*)from * weights[k];                                        \
        s1 += *(const name##_lanes*)(const void*)(from + lead) * weights[k + 1];                           \
        s2 += *(const name##_lanes*)(const void*)(from + 2 * lead) * weights[k + 2];                       \
        s3 += *(const name##_lanes*)(const void*)(from + 3 * lead) * weights[k + 3];                       \
      }                                                                                                    \
      for (; k < count; ++k, from += lead) s0 += *(const name##_lanes*)(const void*)from * weights[k];     \
      *(name##_lanes*)(void*)(out + row) = (s0 + s1) + (s2 + s3);                                          \
    }                                                                                                      \
  }

#if defined(__AVX512F__)
SAMARA_EVAL_COMBINE(samara_eval_combine_here, 64, )
#elif defined(__AVX__)
SAMARA_EVAL_COMBINE(samara_eval_combine_here, 32, )
#else
SAMARA_EVAL_COMBINE(samara_eval_combine_here, 16, )
#endif
#if defined(__x86_64__) && !(defined(__AVX2__) && defined(__FMA__)) && !defined(SAMARA_EVAL_ONE_MACHINE)
/* Where the compiler was not told of the machine: once more for processors of x86 since 2013, and the program looks
 * which it runs on. */
SAMARA_EVAL_COMBINE(samara_eval_combine_avx2, 32, __attribute__((target("avx2,fma"))))
#define SAMARA_EVAL_HAS_AVX2
#endif
#else
/* By plain loops, of which compilers make vectors where they know that arrays do not overlap. */
#if defined(_MSC_VER) || defined(__GNUC__)
#define SAMARA_EVAL_RESTRICT __restrict
#elif defined(__STDC_VERSION__) && __STDC_VERSION__ >= 199901L
#define SAMARA_EVAL_RESTRICT restrict
#else
#define SAMARA_EVAL_RESTRICT
#endif
static void samara_eval_combine_here(const double* SAMARA_EVAL_RESTRICT columns, size_t lead, size_t rows,
                                     size_t count, const double* SAMARA_EVAL_RESTRICT weights,
                                     double* SAMARA_EVAL_RESTRICT out) {
  const size_t end = samara_eval_padded(rows);
  size_t row, i, k;
  for (row = 0; row < end; ++row) out[row] = 0.0;
  for (k = 0; k + 4 <= count; k += 4, columns += 4 * lead) {
    const double w0 = weights[k], w1 = weights[k + 1], w2 = weights[k + 2], w3 = weights[k + 3];
    const double *const a = columns + lead, *const b = a + lead, *const c = b + lead;
    for (row = 0; row < end; row += SAMARA_EVAL_PAD)
      for (i = row; i < row + SAMARA_EVAL_PAD; ++i)
        out[i] += (columns[i] * w0 + a[i] * w1) + (b[i] * w2 + c[i] * w3);
  }
  for (; k < count; ++k, columns += lead)
    for (row = 0; row < end; ++row) out[row] += columns[row] * weights[k];
}
#endif

static samara_eval_combine samara_eval_best_combine(void) {
#ifdef SAMARA_EVAL_HAS_AVX2
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return samara_eval_combine_avx2;
#endif
  return samara_eval_combine_here;
}

/* Weights of the nodes of an element. By products of differences: accurate to a few eps of each of them. */
static void samara_eval_products(const samara_eval_axis* axis, double place, double* value) {
  const size_t n = axis->touched;
  double before = 1.0, after = 1.0;
  size_t j;
  for (j = 0; j < n; ++j) {
    value[j] = axis->lambda[j] * before;
    before *= 2.0 * (place - axis->reference[j]);
  }
  for (j = n; j-- > 0;) {
    value[j] *= after;
    after *= 2.0 * (place - axis->reference[j]);
  }
}

/* The same for many nodes: the second barycentric formula. */
static void samara_eval_barycentric(const samara_eval_axis* axis, double place, double* value) {
  double sum = 0.0;
  size_t j;
  for (j = 0; j < axis->touched; ++j) {
    const double difference = place - axis->reference[j];
    if (difference == 0.0) {
      memset(value, 0, axis->touched * sizeof(double));
      value[j] = 1.0;
      return;
    }
    value[j] = axis->lambda[j] / difference;
    sum += value[j];
  }
  for (j = 0; j < axis->touched; ++j) value[j] /= sum;
}

/* Of the trigonometric polynomial through all nodes. */
static void samara_eval_trigonometric(const samara_eval_axis* axis, double x, double* value) {
  const double pi = 3.14159265358979323846, length = axis->upper - axis->lower;
  const int inside = x >= axis->lower && x < axis->upper;
  const double wrapped = inside ? x : x - length * floor((x - axis->lower) / length);
  double sum = 0.0;
  size_t j;
  for (j = 0; j < axis->nodes; ++j) {
    const double difference = wrapped - axis->places[j];
    if (difference == 0.0) {
      memset(value, 0, axis->nodes * sizeof(double));
      value[j] = 1.0;
      return;
    }
    value[j] = (j % 2 == 0 ? 1.0 : -1.0) / sin(pi * difference / length);
    sum += value[j];
  }
  for (j = 0; j < axis->nodes; ++j) value[j] /= sum;
}

/* Weights of the nodes that x touches and, where `slope` is not null, their derivatives; returns the first node. */
static size_t samara_eval_weights(const samara_eval_axis* axis, samara_eval_combine combine, double x,
                                  double* value, double* slope) {
  size_t element, j;
  double left, right, distance, place, scale;
  if (axis->kind == SAMARA_EVAL_LIST) {
    const size_t node = samara_eval_lower_bound(axis->places, axis->nodes, x);
    value[0] = 1.0;
    if (slope != NULL) slope[0] = (double)NAN;
    return node < axis->nodes ? node : axis->nodes - 1;
  }
  if (axis->kind == SAMARA_EVAL_PERIODIC) {
    samara_eval_trigonometric(axis, x, value);
    if (slope != NULL) combine(axis->slopes, axis->lead, axis->touched, axis->touched, value, slope);
    return 0;
  }
  /* At a border, the element on the left. */
  element = axis->elements == 1 ? 0 : samara_eval_lower_bound(axis->places + 1, axis->elements - 1, x);
  left = axis->places[element];
  right = axis->places[element + 1];
  distance = axis->distances[element];
  place = axis->transform == SAMARA_EVAL_NONE ? ((x - left) - (right - x)) / distance
                                              : (samara_eval_distance(axis->transform, left, x) -
                                                 samara_eval_distance(axis->transform, x, right)) /
                                                    distance;
  if (axis->touched <= SAMARA_EVAL_MOST_PRODUCTS) {
    samara_eval_products(axis, place, value);
  } else {
    samara_eval_barycentric(axis, place, value);
  }
  if (slope != NULL) {
    combine(axis->slopes, axis->lead, axis->touched, axis->touched, value, slope);
    scale = 2.0 / distance * samara_eval_transform_slope(axis->transform, x);
    for (j = 0; j < axis->touched; ++j) slope[j] *= scale;
  }
  return element * (axis->touched - 1);
}

/* A point ------------------------------------------------------------------------------------------------ */

static int samara_eval_holds(const samara_eval* book, const samara_eval_piece* piece, const double* x) {
  size_t k;
  for (k = 0; k < book->coordinates; ++k) {
    const samara_eval_axis* const axis = piece->axes + k;
    size_t node;
    if (!(x[k] >= piece->box[2 * k] && x[k] <= piece->box[2 * k + 1])) return 0;
    if (axis->kind != SAMARA_EVAL_LIST) continue;
    node = samara_eval_lower_bound(axis->places, axis->nodes, x[k]);
    if (node == axis->nodes || axis->places[node] != x[k]) return 0;
  }
  return 1;
}

/* The first piece that holds a point; null in a gap. */
static const samara_eval_piece* samara_eval_find(const samara_eval* book, const double* x) {
  size_t at = samara_eval_lower_bound(book->borders, book->border_count, x[0]), i, end;
  if (at == book->border_count) return NULL;
  i = samara_eval_count(book, book->starts + at);
  end = samara_eval_count(book, book->starts + at + 1);
  for (; i < end; ++i) {
    const samara_eval_piece* const piece = book->piece_list + samara_eval_count(book, book->candidates + i);
    if (samara_eval_holds(book, piece, x)) return piece;
  }
  return NULL;
}

/* Outputs of a group at a point, by the weights of all axes. Columns are carried from the last axis to the first: the
 * value v and derivatives t_m by later axes m; with the blend S of axis k and its derivative S', v <- S v, t_m <- S
 * t_m and t_k = S' v. Column 0 is v, column 1 + m is t_m. */
static void samara_eval_group_at(const samara_eval* book, const samara_eval_piece* piece,
                                 const samara_eval_group* group, samara_eval_combine combine, double* work,
                                 double* values, double* gradient) {
  const size_t d = book->coordinates, lead = book->column_lead;
  const double* const weights = work + samara_eval_padded(d);
  double* const blend = work + samara_eval_padded(d) + 2 * d * book->weights_lead;
  double* const slope = blend + book->blend_lead;
  double* columns = slope + book->blend_lead;
  double* next = columns + (d + 1) * lead;
  size_t k, m, i;
  for (k = d; k-- > 0;) {
    const samara_eval_core* const core = group->cores + k;
    const size_t touched = piece->axes[k].touched;
    const double* const data = core->data + (size_t)work[k] * core->stride;
    const double* const value_weights = weights + 2 * k * book->weights_lead;
    const int is_last = k + 1 == d;
    double* swapped;
    combine(data, core->stride, core->stride, touched, value_weights, is_last ? next : blend);
    if (gradient != NULL)
      combine(data, core->stride, core->stride, touched, value_weights + book->weights_lead,
              is_last ? next + (1 + k) * lead : slope);
    if (!is_last) {
      for (m = 0; m <= d; ++m) {
        const int is_own = m == 1 + k; /* t_k, of v */
        const double* const matrix = is_own ? slope : blend;
        const double* const from = columns + (is_own ? 0 : m * lead);
        if (m > 0 && (gradient == NULL || m < 1 + k)) continue;
        if (group->is_train) {
          combine(matrix, core->left, core->left, core->right, from, next + m * lead);
        } else {
          for (i = 0; i < core->stride; ++i) next[m * lead + i] = matrix[i] * from[i];
        }
      }
    }
    swapped = columns;
    columns = next;
    next = swapped;
  }
  for (m = 0; m <= (gradient != NULL ? d : 0); ++m) {
    const double* rows = columns + m * lead;
    if (group->front != NULL) {
      combine(group->front, group->front_lead, group->outputs, group->front_rank, rows, next + m * lead);
      rows = next + m * lead;
    }
    for (i = 0; i < group->outputs; ++i) {
      const size_t output = group->first_output + i;
      if (m == 0) {
        values[output] = rows[i];
      } else {
        gradient[output * d + m - 1] = rows[i];
      }
    }
  }
}

/* Quaternions get the length with which they began: u = L q/|q|, n = |q|/L, u_k = (q_k - u (u.q_k)/L^2) / n. */
static void samara_eval_restore(const samara_eval* book, double* values, double* gradient) {
  const size_t d = book->coordinates;
  const double length = book->attitude_length;
  double n = 0.0, u[4];
  size_t i, k;
  for (i = 0; i < 4; ++i) n += values[book->attitude[i]] * values[book->attitude[i]];
  n = sqrt(n) / length;
  for (i = 0; i < 4; ++i) values[book->attitude[i]] = u[i] = values[book->attitude[i]] / n;
  for (k = 0; gradient != NULL && k < d; ++k) {
    double slope = 0.0;
    for (i = 0; i < 4; ++i) slope += u[i] * gradient[book->attitude[i] * d + k];
    slope /= length * length;
    for (i = 0; i < 4; ++i) {
      double* const by = gradient + book->attitude[i] * d + k;
      *by = (*by - u[i] * slope) / n;
    }
  }
}

samara_eval_status samara_eval_point(const samara_eval* book, double* work, const double* x, double* values,
                                     double* gradient) {
  const samara_eval_combine combine = samara_eval_best_combine();
  const samara_eval_piece* piece;
  size_t k, g;
  if (book == NULL || work == NULL || x == NULL || values == NULL) return SAMARA_EVAL_WRONG_CALL;
  for (k = 0; k < book->coordinates; ++k)
    if (!samara_eval_is_finite(x[k])) return SAMARA_EVAL_WRONG_CALL;
  piece = samara_eval_find(book, x);
  if (piece == NULL) return SAMARA_EVAL_OUTSIDE;
  work += (64 - (uintptr_t)work % 64) % 64 / 8;
  for (k = 0; k < book->coordinates; ++k) {
    double* const weights = work + samara_eval_padded(book->coordinates) + 2 * k * book->weights_lead;
    work[k] = (double)samara_eval_weights(piece->axes + k, combine, x[k], weights,
                                          gradient == NULL ? NULL : weights + book->weights_lead);
  }
  for (g = 0; g < piece->group_count; ++g)
    samara_eval_group_at(book, piece, piece->groups + g, combine, work, values, gradient);
  if (book->has_attitude) samara_eval_restore(book, values, gradient);
  return SAMARA_EVAL_DONE;
}

int samara_eval_outside(const samara_eval* book, const double* x) {
  size_t k;
  for (k = 0; book != NULL && x != NULL && k < book->coordinates; ++k) {
    double lower = 0.0, upper = 0.0;
    samara_eval_bounds(book, (int)k, &lower, &upper);
    if (!samara_eval_is_finite(x[k]) || !(x[k] >= lower && x[k] <= upper)) return (int)k;
  }
  return -1;
}

#ifdef __cplusplus
}
#endif

#endif /* SAMARA_EVAL_IMPLEMENTATION */
