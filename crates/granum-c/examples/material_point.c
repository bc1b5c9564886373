/* A material point from C: a sample is prepared and compressed along z, tries and goes back, and asks for the stiffness.
 *
 *     cc -I include examples/material_point.c -L ../../target/release -lgranum_c -lm -o material_point
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "granum.h"

static void check(int code, const char *what) {
    if (code != GRANUM_OK) {
        fprintf(stderr, "%s: %s (code %d)\n", what, granum_last_error(), code);
        exit(1);
    }
}

int main(void) {
    const char *text = "grains.count = 50\n"
                       "grains.material.interface_energy = 0\n"
                       "preparation.solid_fraction = 'none'\n"
                       "preparation.friction = 0.1\n"
                       "preparation.mean_stress = '100 kPa'\n"
                       "preparation.inertial_number = 0.02\n"
                       "preparation.unbalanced_force = 0.1\n";
    if (granum_interface_version() != GRANUM_INTERFACE_VERSION) {
        fprintf(stderr, "header and library are of different versions\n");
        return 1;
    }
    granum_controls controls;
    check(granum_controls_default(&controls), "controls");
    controls.inertial_number = 5e-3;

    granum_point *point = NULL;
    check(granum_point_from_case_text(text, &controls, &point), "the sample");
    granum_state *start = NULL, *trial = NULL, *state = NULL, *again = NULL;
    check(granum_point_start(point, &start), "the start");

    /* A trial that is not taken, and the one that is: the start is not changed by either. */
    double large[6] = {0, 0, 5e-3, 0, 0, 0}, strain[6] = {0, 0, 1e-3, 0, 0, 0};
    check(granum_point_advance(point, start, large, NULL, &trial), "a trial");
    check(granum_point_advance(point, start, strain, NULL, &state), "an increment");
    check(granum_point_advance(point, start, strain, NULL, &again), "the same increment");
    double stress[6], same[6], noise[6];
    check(granum_state_stress(state, stress), "its stress");
    check(granum_state_stress(again, same), "the same stress");
    check(granum_state_noise(state, noise), "its noise");
    if (memcmp(stress, same, sizeof stress) != 0) return 1;
    printf("version %s: stress along z %.0f Pa with a noise of %.0f Pa\n", granum_version(), stress[2], noise[2]);

    double stiffness[36], coordination_number;
    check(granum_point_tangent(point, state, GRANUM_TANGENT_AFFINE, 0.0, stiffness), "its stiffness");
    check(granum_state_sensor(state, "coordination_number", &coordination_number), "a sensor");
    printf("affine stiffness C_zz,zz %.3e Pa, coordination number %.2f\n", stiffness[6 * 2 + 2], coordination_number);

    /* What is not possible is a code and a message. */
    double absurd[6] = {NAN, 0, 0, 0, 0, 0};
    granum_state *none = NULL;
    if (granum_point_advance(point, state, absurd, NULL, &none) != GRANUM_ERROR_REFUSED || none != NULL) return 1;
    printf("refused: %s\n", granum_last_error());
    if (granum_state_sensor(state, "no_such_column", &coordination_number) != GRANUM_ERROR_ARGUMENT) return 1;
    if (granum_state_stress(NULL, stress) != GRANUM_ERROR_ARGUMENT) return 1;
    if (granum_point_from_case("/no/such/case.toml", NULL, &point) != GRANUM_ERROR_FILE) return 1;

    granum_state_free(start);
    granum_state_free(trial);
    granum_state_free(state);
    granum_state_free(again);
    granum_state_free(NULL);
    granum_point_free(point);
    printf("well\n");
    return 0;
}
