/* Material points of granum: samples of grains that a program strains step by step.
 *
 * Compression is positive, stresses are in pascals, and the six components are xx, yy, zz, yz, zx, xy with shear strains as angles.
 * Each function but those that free something returns GRANUM_OK or the code of an error, whose text granum_last_error() has. Handles can be
 * used from several threads at the same time; each is freed once. States are never changed.
 *
 * Made by scripts/c-header from the sources; do not edit. */

#ifndef GRANUM_H
#define GRANUM_H

#include <stdint.h>

/*
 Everything is well.
 */
#define GRANUM_OK 0

/*
 A pointer is null, a text is no UTF-8, or a number is not possible.
 */
#define GRANUM_ERROR_ARGUMENT 1

/*
 A case, a configuration or a file of states cannot be read or written.
 */
#define GRANUM_ERROR_FILE 2

/*
 The point gives no answer to an increment or a stress; states are as they were.
 */
#define GRANUM_ERROR_REFUSED 3

/*
 There is no such point or ticket.
 */
#define GRANUM_ERROR_UNKNOWN 4

/*
 A mistake in granum itself.
 */
#define GRANUM_ERROR_INTERNAL 5

/*
 Version of the interface: it changes when a function or a structure of this header does in a way that callers must know.
 */
#define GRANUM_INTERFACE_VERSION 1

/*
 The stiffness if every grain follows the strain of the cell.
 */
#define GRANUM_TANGENT_AFFINE 0

/*
 The elastic stiffness, without sliding.
 */
#define GRANUM_TANGENT_ELASTIC 1

/*
 Central differences of the answers to small strains.
 */
#define GRANUM_TANGENT_PROBES 2

/*
 The secant that is kept up along the path.
 */
#define GRANUM_TANGENT_SECANT 3

/*
 A material point: a sample, and how it is strained. It can be used from any number of threads at the same time.
 */
typedef struct granum_point granum_point;

/*
 A state of a material point. It is never changed, and can be used from any number of threads at the same time.
 */
typedef struct granum_state granum_state;

/*
 The states of many points under tickets. It can be used from any number of threads at the same time.
 */
typedef struct granum_store granum_store;

/*
 Controls of a live cell; `granum_controls_default` fills them in.
 */
typedef struct granum_controls {
  /*
   Inertial number of the straining.
   */
  double inertial_number;
  /*
   Steps for which the cell is held after an increment.
   */
  uint64_t relaxation;
  /*
   The last steps of the relaxation over which the stress is averaged.
   */
  uint64_t averaging;
  /*
   Largest size of an increment, sqrt(2/3 e:e), that is carried out in one piece.
   */
  double largest_increment;
  /*
   Not zero if a larger increment is refused; zero if it is divided.
   */
  int refuse_larger;
  /*
   Size from which on an increment is refused in any case.
   */
  double absurd_increment;
  /*
   Mean stress, Pa, whose strain rate is the smallest one; zero for a hundredth of that of the sample.
   */
  double least_mean_stress;
  /*
   Largest number of steps of an increment.
   */
  uint64_t most_steps;
  /*
   Largest overlap of grains over the sum of their radii.
   */
  double largest_overlap;
} granum_controls;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 The message of the last error of this thread; an empty text if there was none. It is valid until the next call of a function of granum
 on this thread.
 */
const char *granum_last_error(void);

/*
 Opens a configuration for the user materials of this process, in place of the one that is open. Without this call the first question of
 the host opens the one that the environment variable GRANUM_MATERIALS names, or granum-materials.toml in the working folder.
 */
int granum_points_open(const char *configuration);

/*
 Writes the states of all points of the user materials of this process to a file.
 */
int granum_points_save(const char *path);

/*
 Reads the states of all points of the user materials of this process from a file, in place of those that there are.
 */
int granum_points_load(const char *path);

/*
 Why a user material last answered with NaN or stopped the host, on any thread; an empty text if it never did. The text is valid until
 the next call of a function of granum on this thread.
 */
const char *granum_points_message(void);

/*
 Version of granum, for example "0.1.0".
 */
const char *granum_version(void);

/*
 Version of the interface of the library; compare it with `GRANUM_INTERFACE_VERSION` of the header.
 */
uint32_t granum_interface_version(void);

/*
 Fills in the default controls.
 */
int granum_controls_default(struct granum_controls *controls);

/*
 Makes a point whose sample is prepared as a case file says. `controls` may be null for the default ones. `*point` is to be freed with
 `granum_point_free`.
 */
int granum_point_from_case(const char *path,
                           const struct granum_controls *controls,
                           struct granum_point **point);

/*
 The same from the text of a case.
 */
int granum_point_from_case_text(const char *case_, const struct granum_controls *controls, struct granum_point **point);

/*
 Frees a point; null is nothing. States and stores that came from it can still be used.
 */
void granum_point_free(struct granum_point *point);

/*
 The state of the sample before any increment. `*state` is to be freed with `granum_state_free`.
 */
int granum_point_start(const struct granum_point *point, struct granum_state **state);

/*
 The answer to an increment: the sample is rotated (`rotation`, nine numbers row by row; null for no rotation) and then strained by a
 logarithmic strain (six numbers xx, yy, zz, yz, zx, xy, compression positive, shear strains as angles, in the axes of space). `state`
 is not changed; `*answer` is the new state and is to be freed with `granum_state_free`.
 */
int granum_point_advance(const struct granum_point *point,
                         const struct granum_state *state,
                         const double *strain,
                         const double *rotation,
                         struct granum_state **answer);

/*
 The state brought to a stress (six numbers, Pa, compression positive). `*answer` is to be freed with `granum_state_free`.
 */
int granum_point_at_stress(const struct granum_point *point,
                           const struct granum_state *state,
                           const double *stress,
                           struct granum_state **answer);

/*
 The stiffness of a state, Pa: 36 numbers row by row, `d_sigma_i = C[6 i + j] d_eps_j`. `kind` is one of `GRANUM_TANGENT_...`;
 `probe_strain` counts for `GRANUM_TANGENT_PROBES` only.
 */
int granum_point_tangent(const struct granum_point *point,
                         const struct granum_state *state,
                         int kind,
                         double probe_strain,
                         double *stiffness);

/*
 Another handle of the same state, which is to be freed as well.
 */
int granum_state_clone(const struct granum_state *state, struct granum_state **clone);

/*
 Frees a state; null is nothing.
 */
void granum_state_free(struct granum_state *state);

/*
 The stress, Pa: six numbers xx, yy, zz, yz, zx, xy, compression positive, in the axes of space.
 */
int granum_state_stress(const struct granum_state *state, double *stress);

/*
 The standard deviation of the six components of the stress, Pa, in the axes of the cell: of grains that over the steps of their average, of a
 surrogate that of its prediction for a new sample.
 */
int granum_state_noise(const struct granum_state *state,
                       double *noise);

/*
 The void ratio: volume of the voids over that of the grains. A surrogate may not know it.
 */
int granum_state_void_ratio(const struct granum_state *state, double *void_ratio);

/*
 Number of the inputs and other quantities of a state that are outside of what its surrogate was trained on: its answer should not be trusted if there are
 any. Zero for grains.
 */
int granum_state_outside(const struct granum_state *state,
                         uint64_t *count);

/*
 One if grains are behind the state, zero if a surrogate is: of a material of both it tells who answered.
 */
int granum_state_is_live(const struct granum_state *state, int *is_live);

/*
 A value of a sensor by the name of its column, for example "coordination_number" or "phi_d", or of an output of a surrogate.
 */
int granum_state_sensor(const struct granum_state *state,
                        const char *column,
                        double *value);

/*
 The ticket of a state: a whole number from 1 to 2^52, which is the same in every process.
 */
int granum_state_ticket(const struct granum_state *state, uint64_t *ticket);

/*
 An empty store. `*store` is to be freed with `granum_store_free`.
 */
int granum_store_new(struct granum_store **store);

/*
 Frees a store with all its states; null is nothing.
 */
void granum_store_free(struct granum_store *store);

/*
 Keeps a state as the accepted one of a point, whose name is any number, and gives its ticket.
 */
int granum_store_put(const struct granum_store *store,
                     uint64_t name,
                     const struct granum_state *state,
                     uint64_t *ticket);

/*
 The answer of a point to an increment from the state of a ticket, which is thereby accepted: what was tried otherwise is dropped.
 `host_stress` (six numbers, Pa, compression positive) may be null; if it differs from the stress of the state, the point is brought to
 it first. `strain` and `rotation` are those of `granum_point_advance`. The ticket and the stress of the new state are written; `stress`
 may be null.
 */
int granum_store_advance(const struct granum_store *store,
                         uint64_t name,
                         uint64_t ticket,
                         const struct granum_point *point,
                         const double *host_stress,
                         const double *strain,
                         const double *rotation,
                         uint64_t *new_ticket,
                         double *stress);

/*
 The state of a ticket, without taking it as accepted. `*state` is to be freed with `granum_state_free`.
 */
int granum_store_state(const struct granum_store *store,
                       uint64_t name,
                       uint64_t ticket,
                       const struct granum_point *point,
                       struct granum_state **state);

/*
 Writes all points of a store to a file, beside its place and then renamed.
 */
int granum_store_save(const struct granum_store *store, const char *path);

/*
 Reads a store from a file. `*store` is to be freed with `granum_store_free`.
 */
int granum_store_load(const char *path, struct granum_store **store);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* GRANUM_H */
