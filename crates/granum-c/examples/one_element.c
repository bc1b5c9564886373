/* One element around Abaqus's UMAT: a drained triaxial test with the calling convention of Fortran. The axial strain is prescribed, and the
 * lateral strains are found by Newton's iteration with DDSDDE so that the lateral stresses stay. Steps are cut when the UMAT answers NaN.
 *
 *     cc -I include examples/one_element.c -L ../../target/release -lgranum_c -lm -o one_element
 *     ./one_element granum-materials.toml 10 1e-4
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "granum.h"

void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl, double *ddsddt,
           double *drplde, double *drpldt, const double *stran, const double *dstran, const double *time, const double *dtime,
           const double *temp, const double *dtemp, const double *predef, const double *dpred, const char *cmname, const int *ndi,
           const int *nshr, const int *ntens, const int *nstatv, const double *props, const int *nprops, const double *coords,
           const double *drot, double *pnewdt, const double *celent, const double *dfgrd0, const double *dfgrd1, const int *noel,
           const int *npt, const int *layer, const int *kspt, const int *kstep, const int *kinc);

enum { NTENS = 6, NSTATV = 5 };
static int calls;

/* Stress, state and stiffness after an increment from an accepted state, which is not changed. */
static void ask(const double stress0[NTENS], const double statev0[NSTATV], const double dstran[NTENS], double stress[NTENS],
                double statev[NSTATV], double ddsdde[NTENS * NTENS]) {
    const int ndi = 3, nshr = 3, ntens = NTENS, nstatv = NSTATV, nprops = 1;
    const double props[1] = {1.0}, one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double pnewdt = 1.0;
    memcpy(stress, stress0, NTENS * sizeof *stress);
    memcpy(statev, statev0, NSTATV * sizeof *statev);
    ++calls;
    umat_(stress, statev, ddsdde, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, dstran, NULL, NULL, NULL, NULL, NULL, NULL, NULL,
          &ndi, &nshr, &ntens, &nstatv, props, &nprops, NULL, one, &pnewdt, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL);
    if (isnan(stress[0]) && pnewdt >= 1.0) exit(2);
}

int main(int argc, char **argv) {
    if (argc != 4 || granum_points_open(argv[1]) != GRANUM_OK) {
        fprintf(stderr, "usage: one_element CONFIGURATION STEPS STRAIN: %s\n", granum_last_error());
        return 1;
    }
    const int steps = atoi(argv[2]);
    const double axial = -atof(argv[3]);
    const double p0 = 100e3;
    double stress[NTENS] = {-p0, -p0, -p0, 0, 0, 0}, statev[NSTATV] = {1.0, 0.0};
    for (int step = 1; step <= steps; ++step) {
        double trial[NTENS], trial_state[NSTATV], d[NTENS * NTENS], strain[NTENS] = {0, 0, axial, 0, 0, 0};
        int iteration = 0;
        for (;; ++iteration) {
            if (iteration > 200) {
                fprintf(stderr, "step %d does not converge\n", step);
                return 1;
            }
            ask(stress, statev, strain, trial, trial_state, d);
            if (isnan(trial[0])) {
                fprintf(stderr, "refused: %s\n", granum_points_message());
                return 1;
            }
            const double rx = -p0 - trial[0], ry = -p0 - trial[1];
            if (fmax(fabs(rx), fabs(ry)) < 1e-3 * p0) break;
            /* Two equations; D(i, j) by columns. */
            const double a = d[0], b = d[NTENS], c = d[1], e = d[NTENS + 1], det = a * e - b * c;
            strain[0] += (e * rx - b * ry) / det;
            strain[1] += (a * ry - c * rx) / det;
        }
        memcpy(stress, trial, sizeof stress);
        memcpy(statev, trial_state, sizeof statev);
        printf("step %d: szz %.1f Pa, sxx %.1f Pa, lateral strain %.3e, void ratio %.4f, iterations %d, ticket %.0f\n", step,
               stress[2], stress[0], strain[0], statev[2], iteration, statev[1]);
    }
    printf("calls %d\n", calls);
    return 0;
}
