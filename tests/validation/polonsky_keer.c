/* Conjugate gradients of Polonsky and Keer on the elastic half-space, by Fourier sums along rows and columns.
   It reads parameters.txt and heights.txt of the current folder and writes pressure.txt. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int nx, ny;
static double *soft, *re, *im, *cx, *sx, *cy, *sy;

static double *numbers(size_t n) { return calloc(n, sizeof(double)); }

/* Transform all lines of n points that lie `step` apart; sign -1 forward, +1 backward. */
static void sums(int lines, int apart, int n, int step, const double *c, const double *s, int sign) {
    double *ar = numbers(n), *ai = numbers(n);
    for (int l = 0; l < lines; l++) {
        double *r = re + (size_t)l * apart, *i = im + (size_t)l * apart;
        for (int k = 0; k < n; k++) {
            double a = 0, b = 0;
            for (int j = 0, t = 0; j < n; j++, t = (t + k) % n) {
                double x = r[(size_t)j * step], y = i[(size_t)j * step], w = sign * s[t];
                a += x * c[t] - y * w;
                b += x * w + y * c[t];
            }
            ar[k] = a, ai[k] = b;
        }
        for (int k = 0; k < n; k++) r[(size_t)k * step] = ar[k], i[(size_t)k * step] = ai[k];
    }
    free(ar), free(ai);
}

/* u = displacement under p, without its mean. */
static void bend(const double *p, double *u) {
    size_t n = (size_t)nx * ny;
    memcpy(re, p, n * sizeof(double)), memset(im, 0, n * sizeof(double));
    sums(nx, ny, ny, 1, cy, sy, -1), sums(ny, 1, nx, ny, cx, sx, -1);
    for (size_t k = 0; k < n; k++) re[k] *= soft[k], im[k] *= soft[k];
    sums(nx, ny, ny, 1, cy, sy, 1), sums(ny, 1, nx, ny, cx, sx, 1);
    for (size_t k = 0; k < n; k++) u[k] = re[k] / n;
}

static void circle(int n, double **c, double **s) {
    *c = numbers(n), *s = numbers(n);
    for (int k = 0; k < n; k++) (*c)[k] = cos(2 * M_PI * k / n), (*s)[k] = sin(2 * M_PI * k / n);
}

/* Take out of v its mean over the contact. */
static void level(double *v, const double *p, size_t n) {
    double sum = 0;
    size_t count = 0;
    for (size_t k = 0; k < n; k++) if (p[k] > 0) sum += v[k], count++;
    for (size_t k = 0; k < n; k++) v[k] -= sum / count;
}

int main(void) {
    double wx, wy, lx, ly, modulus, load, tolerance;
    FILE *file = fopen("parameters.txt", "r");
    if (!file || fscanf(file, "%lf %lf %lf %lf %lf %lf %lf", &wx, &wy, &lx, &ly, &modulus, &load, &tolerance) != 7)
        return 1;
    fclose(file);
    nx = (int)wx, ny = (int)wy;
    size_t n = (size_t)nx * ny;
    double *h = numbers(n), *p = numbers(n), *gap = numbers(n), *way = numbers(n), *pull = numbers(n);
    soft = numbers(n), re = numbers(n), im = numbers(n);
    circle(nx, &cx, &sx), circle(ny, &cy, &sy);
    file = fopen("heights.txt", "r");
    for (size_t k = 0; k < n; k++) if (!file || fscanf(file, "%lf", &h[k]) != 1) return 1;
    fclose(file);
    double mean = 0, spread = 0;
    for (size_t k = 0; k < n; k++) mean += h[k] / n, p[k] = load;
    for (size_t k = 0; k < n; k++) spread += (h[k] - mean) * (h[k] - mean) / n;
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < ny; j++) {
            double q = hypot(2 * M_PI / lx * (i > nx / 2 ? i - nx : i), 2 * M_PI / ly * (j > ny / 2 ? j - ny : j));
            soft[(size_t)i * ny + j] = q > 0 ? 2 / (modulus * q) : 0;
        }
    double last = 1;
    for (int step = 0, fresh = 1; step < 1000; step++) {
        double size = 0, along = 0, stiff = 0, sum = 0;
        bend(p, gap);
        for (size_t k = 0; k < n; k++) gap[k] -= h[k];
        level(gap, p, n);
        for (size_t k = 0; k < n; k++) if (p[k] > 0) size += gap[k] * gap[k];
        if (!fresh && size < 1e-6 * tolerance * tolerance * spread) break;
        if (size == 0) break;
        for (size_t k = 0; k < n; k++) way[k] = p[k] > 0 ? gap[k] + (fresh ? 0 : size / last) * way[k] : 0;
        bend(way, pull);
        level(pull, p, n);
        for (size_t k = 0; k < n; k++) if (p[k] > 0) along += gap[k] * way[k], stiff += pull[k] * way[k];
        double length = along / stiff;
        fresh = 0;
        for (size_t k = 0; k < n; k++) p[k] = fmax(p[k] - length * way[k], 0);
        for (size_t k = 0; k < n; k++) if (p[k] == 0 && gap[k] < 0) p[k] -= length * gap[k], fresh = 1;
        for (size_t k = 0; k < n; k++) sum += p[k] / n;
        for (size_t k = 0; k < n; k++) p[k] *= load / sum;
        last = size;
    }
    file = fopen("pressure.txt", "w");
    for (int i = 0; file && i < nx; i++)
        for (int j = 0; j < ny; j++) fprintf(file, "%.17g%c", p[(size_t)i * ny + j], j + 1 < ny ? ' ' : '\n');
    return file ? fclose(file) : 1;
}
