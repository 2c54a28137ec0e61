/*
 * A mass beside a disc of ten times the diffusivity: the field on a mesh in a medium, div(G grad u) = density, and what is known of it.
 *
 * With the mass at distance d from the centre of a disc of radius a, u outside the disc is that of the mass and of its image, (1 - G) / (1 + G) times it at a^2 / d,
 * with the opposite mass at the centre. The result is 0 if the gradients agree within 5 percent, which is what a curved jump costs on a mesh of this width.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "mollis.h"

enum { CELLS = 192, TARGETS = 4 };

static double diffusivity[CELLS + 1][CELLS + 1];

static void check(mollis_status status, const char *what)
{
    if (status != MOLLIS_OK) {
        fprintf(stderr, "%s: %s\n", what, mollis_status_text(status));
        exit(1);
    }
}

/* Adds the gradient of a mass at (at, 0). */
static void add(double mass, double at, const double x[2], double gradient[2])
{
    const double dx = x[0] - at, factor = mass / (2 * 3.14159265358979324 * (dx * dx + x[1] * x[1]));
    gradient[0] += factor * dx;
    gradient[1] += factor * x[1];
}

int main(void)
{
    const double inside = 10, a = 0.5, d = 0.9, image = (1 - inside) / (1 + inside);
    const double mass = 1, place[2] = {0.9, 0}, where[TARGETS][2] = {{-0.7, 0.1}, {0.1, 0.8}, {0.3, -0.7}, {1.3, 0.2}};
    const mollis_mesh2 mesh = {{-3, -3}, {3, 3}, {CELLS, CELLS}};
    double gradient[TARGETS][2], done[2];
    mollis_medium2 medium = {&diffusivity[0][0], NULL, 1e-8, 100, &done};
    mollis_grid2_options options;
    mollis_sources2 sources = {0};
    mollis_targets2 targets = {0};
    mollis_grid2_outputs outputs = {{NULL, NULL}, 0, NULL, NULL, NULL, NULL, NULL};
    size_t bytes;
    void *workspace;
    int i, j, wrong = 0;

    for (j = 0; j <= CELLS; j++) {
        for (i = 0; i <= CELLS; i++) {
            const double x = -3 + 6.0 * i / CELLS, y = -3 + 6.0 * j / CELLS;
            diffusivity[j][i] = x * x + y * y < a * a ? inside : 1;
        }
    }
    check(mollis_grid2_options_init(&options, sizeof options), "options");
    options.medium = &medium;
    sources.n = 1;
    sources.positions[0] = place;
    sources.masses = &mass;
    targets.n = TARGETS;
    targets.positions[0] = where[0];
    outputs.gradient[0] = gradient[0];

    check(mollis_grid2_workspace_bytes(&mesh, &sources, &targets, &outputs, &options, NULL, &bytes), "workspace");
    workspace = malloc(bytes);
    if (workspace == NULL) {
        return 1;
    }
    check(mollis_grid2_eval(&mesh, &sources, &targets, &outputs, &options, NULL, workspace, bytes), "field");
    free(workspace);

    printf("%.0f iterations\n", done[0]);
    for (i = 0; i < TARGETS; i++) {
        double want[2] = {0, 0};
        add(mass, d, where[i], want);
        add(mass * image, a * a / d, where[i], want);
        add(-mass * image, 0, where[i], want);
        printf("(%4.1f, %4.1f): %7.4f %7.4f, exact %7.4f %7.4f\n", where[i][0], where[i][1], gradient[i][0], gradient[i][1], want[0], want[1]);
        wrong |= hypot(gradient[i][0] - want[0], gradient[i][1] - want[1]) > 0.05 * hypot(want[0], want[1]);
    }
    return wrong;
}
