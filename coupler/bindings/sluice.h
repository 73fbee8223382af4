#ifndef SLUICE_H
#define SLUICE_H

/*! Sluice for C, and for every language that can call C. One participant from start to end:
 *
 *      sluice_participant* self;
 *      int status = sluice_join(SLUICE_ABI, argc, (char const* const*)argv, &self);
 *      if (status == 0 && self) status = solve(self);        // your solver; returns the first status that is not 0
 *      return sluice_leave(self, status, NULL);
 *
 *  and in solve(): configuration; sluice_write() for every edge that goes out; then windows until the run is over:
 *
 *      while ((status = sluice_next(self, &window, &more)) == 0 && more) { sluice_read(); ...; sluice_write(); }
 *
 *  Every function but sluice_version(), sluice_error() and sluice_leave() returns a status: 0, or the exit code that
 * the process should end with (README: 2 a mistake in the scene, 3 a peer died, 4 silence, 5 versions that do not
 * match, 6 a number that is not finite, 7 a file, 8 safety, 70 a call that is wrong, 75 and 130 stopped);
 * sluice_error() says what happened. A participant whose call has failed can only leave: every further call returns the
 * same status.
 *
 *  SI units. Texts are UTF-8 and end with 0. Numbers are float64 and ids int64, interleaved point by point. What you
 *  pass is copied or sent before the call returns and stays yours. What you get stays Sluice's: texts until
 *  sluice_leave(), arrays as long as said at the function. One participant belongs to one thread at a time.
 */

#include <stddef.h>
#include <stdint.h>

/*! Number of this interface; grows with every change of it. A library with another one refuses to be joined. */
#define SLUICE_ABI 1

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sluice_participant sluice_participant;
typedef struct sluice_state sluice_state;

/*! What does not change while a participant lives, but for `resumed_at`. */
typedef struct sluice_about
{
    char const* name;      /*!< of this participant in the scene */
    char const* directory; /*!< of the run: results belong there */
    char const* scene;     /*!< its file */
    double gravity[3];     /*!< m/s2 */
    double end;            /*!< of the run, s */
    double resumed_at;     /*!< s; where a resumed run goes on, known after the first sluice_next() */
    int dimension;         /*!< 2 or 3 */
    int rank, ranks;       /*!< which of the participant's processes this is, and how many they are */
    int checking;          /*!< 1: only the configuration is wanted: leave after reading it */
    int resumes;           /*!< 1: this run goes on from a checkpoint */
} sluice_about;

typedef struct sluice_window
{
    int64_t index;
    double begin, end, length; /*!< s */
    int output;                /*!< 1: the state at its end is to be recorded */
    int series;                /*!< 1: a row of the time series is to be written at its end */
    int last;                  /*!< 1: the run ends with it */
    int iteration;             /*!< in an implicit group: how often it has been computed before */
} sluice_window;

/*! What an edge says at one time. Nothing is copied: the arrays are valid until the next sluice_read() of the same edge
 *  or the next sluice_next() or sluice_accepted(). */
typedef struct sluice_frame
{
    size_t points;
    int64_t const* ids;          /*!< [points], lasting */
    size_t columns;              /*!< as many as the data has, in its order: see sluice_column() */
    double const* const* column; /*!< [columns][points * components] */
    size_t const* components;    /*!< [columns] numbers a point */
} sluice_frame;

/* Life */

/*! "0.1.0"; `abi` (may be NULL) gets the SLUICE_ABI that the library was built with. */
char const* sluice_version(int* abi);

/*! The message of this thread's last failure, "" if there was none; `status` (may be NULL) gets its exit code. Valid
 *  until the thread's next failure. */
char const* sluice_error(int* status);

/*! Becomes the participant that the command line says: SCENE --as NAME [--out DIRECTORY] [--set PATH=VALUE]... [--rank
 * K]
 *  [--resume] [--check]; argv[0] is not looked at, so a caller may make its own. `abi` is SLUICE_ABI. SIGTERM is taken
 *  over from here on. `*self` is NULL if it fails, and with status 0 after --help and --version: then just leave. */
int sluice_join(int abi, int argc, char const* const* argv, sluice_participant** self);

int sluice_get_about(sluice_participant* self, sluice_about* about);

/*! The end of a participant, also of NULL. `status` 0: says goodbye to the others and writes the summary. Else tells
 * them, the launcher and standard error why: `message`, or if that is NULL sluice_error(). Returns what the process
 * should end with. `self` is gone then. */
int sluice_leave(sluice_participant* self, int status, char const* message);

/* Configuration: this participant's `config` block in the scene. Mistakes are collected; sluice_end_config() fails with
   all of them at once, each with file:line:column. */

/*! One number, or (count > 1) a list of `count` numbers, in `unit` ("" for none). `fallback` [count] is for an absent
 * key; NULL: the key must be there. */
int sluice_number(sluice_participant* self, char const* key, char const* unit, size_t count, double const* fallback,
                  double* values);
/*! A word or a text; `fallback` NULL: the key must be there. */
int sluice_text(sluice_participant* self, char const* key, char const* fallback, char const** value);
/*! true (1) or false (0). */
int sluice_flag(sluice_participant* self, char const* key, int fallback, int* value);
/*! A mistake of the value of `key` that only the solver can see: "path = value TEXT", e.g. "(must be even)." */
int sluice_refuse(sluice_participant* self, char const* key, char const* text);
/*! Refuses keys that nobody asked for; exit 2 with every mistake of the scene. */
int sluice_end_config(sluice_participant* self);

/* Before the first window */

/*! The data that this solver can send and take: lists of names that end with NULL. A list that is NULL says nothing.
 *  Before sluice_end_config(), which reports edges that the solver does not know. */
int sluice_exchanges(sluice_participant* self, char const* const* sends, char const* const* takes);
/*! Who is at the other end: the k-th participant that gets (`outgoing` 1) or sends (0) `data`; NULL behind the last. */
int sluice_partner(sluice_participant* self, char const* data, int outgoing, size_t k, char const** name);
/*! The k-th column of `data`: its name (NULL behind the last), unit, and numbers a point. Unknown data: exit 70. */
int sluice_column(sluice_participant* self, char const* data, size_t k, char const** name, char const** unit,
                  size_t* components);
/*! For `window: auto` [s]. `exact`: the solver's own step, every window must have this length; else an upper bound. */
int sluice_propose_window(sluice_participant* self, double seconds, int exact);
/*! The part of space that this process covers [m], 3 numbers each: points with a position outside are not sent to it.
    min above max in x: nothing, no points are sent to it at all. */
int sluice_covers(sluice_participant* self, double const* min, double const* max);

/* What the solver needs to go on bit for bit, for checkpoints and for implicit groups, as named arrays. */

enum
{
    SLUICE_FLOAT64 = 0,
    SLUICE_INT64 = 1,
    SLUICE_BYTES = 2
};
/*! `save` puts every array into the empty `state`, `restore` gets them. Both are called inside of sluice_next(),
 *  sluice_accepted() and sluice_leave(), and return 0, or a status that the call then fails with. */
int sluice_keeps(sluice_participant* self, int (*save)(void* context, sluice_state* state),
                 int (*restore)(void* context, sluice_state* state), void* context);
/*! Copies `size` values of `type`. A name has 1 to 200 letters, digits, _ - . : / and is not taken, else exit 70. */
int sluice_put(sluice_state* state, char const* name, int type, void const* values, size_t size);
/*! Views the array, valid inside of `restore`; no such array, or one of another type: exit 7. */
int sluice_get(sluice_state* state, char const* name, int type, void const** values, size_t* size);

/* Windows */

/*! The state for an out-edge: once for each of them before the first sluice_next() (not when the run is resumed) and
 * once in each window. `column` [columns], each with `size[c]` = points * components numbers. Wrong sizes, twice, or
 * not at all: exit 70. Numbers must be finite: exit 6. */
int sluice_write(sluice_participant* self, char const* to, char const* data, size_t points, int64_t const* ids,
                 size_t columns, double const* const* column, size_t const* size);
/*! Exchanges until the next window can be computed. `more` 0: the run is over, leave. The first call meets the others.
 */
int sluice_next(sluice_participant* self, sluice_window* window, int* more);
/*! What an in-edge says at a time [s] of the current window, by the edge's lag, prediction and sampling. */
int sluice_read(sluice_participant* self, char const* from, char const* data, double time, sluice_frame* frame);
/*! After the last write of a window: `yes` 0 only in an implicit group, when the window will be computed again. */
int sluice_accepted(sluice_participant* self, int* yes);

enum
{
    SLUICE_NEXT_WINDOW = 0, /*!< windows have `seconds` from the next one on; only by who paces the run, else exit 2 */
    SLUICE_END_RUN = 1,     /*!< the next window is the last one, because of `why`; only by who paces the run */
    SLUICE_CHECKPOINT = 2   /*!< a checkpoint before one of the next windows; by anybody */
};
int sluice_request(sluice_participant* self, int what, double seconds, char const* why);

/* For the report */

int sluice_fact(sluice_participant* self, char const* name, double value);
int sluice_warn(sluice_participant* self, char const* text);

#ifdef __cplusplus
}
#endif

#endif
