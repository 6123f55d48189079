/* Floats whose results do not depend on how wide they are: whole numbers, halves, and what is cut off far from a boundary. */
#include "report.h"

static float matrix[4][4], other[4][4], product[4][4];
static double series[] = {1.0, 0.5, 0.25, 0.125};

static float square_root(float x)
{
    float guess = x > 1 ? x : 1;
    int i;

    for (i = 0; i < 40; i++)
        guess = 0.5f * (guess + x / guess);
    return guess;
}

static double polynomial(double x, const double *c, int n)
{
    double sum = 0;

    while (n-- > 0)
        sum = sum * x + c[n];
    return sum;
}

int main(void)
{
    int i, j, k;
    float sum = 0;
    long long wide;

    for (i = 0; i < 4; i++)
        for (j = 0; j < 4; j++) {
            matrix[i][j] = (float)(i - j) * 0.5f;
            other[i][j] = (float)(i * 4 + j);
        }
    for (i = 0; i < 4; i++)
        for (j = 0; j < 4; j++) {
            sum = 0;
            for (k = 0; k < 4; k++)
                sum += matrix[i][k] * other[k][j];
            product[i][j] = sum;
        }
    for (i = 0; i < 4; i++)
        number("product", (unsigned)(int)(product[i][3 - i] * 2));
    number("root", (unsigned)(int)(square_root(2.0f) * 10000 + 0.25f));
    number("root", (unsigned)(int)(square_root(12345.0f) * 100 + 0.25f));
    number("polynomial", (unsigned)(int)(polynomial(2.0, series, 4) * 8));
    number("quotient", (unsigned)(int)(-1000.0f / 7.0f));
    number("cut", (unsigned)((int)-2.75f + 100 * (int)2.75f));
    number("unsigned", (unsigned)3000000000.0f);
    wide = (long long)(1099511627776.0f * 3);
    number("wide", (unsigned)(wide >> 32));
    number("back", (unsigned)(int)((float)(wide + 4096) / 1048576.0f));
    number("order", (unsigned)((sum < 0) + 2 * (series[1] > series[2]) + 4 * (-0.5f < 0.25f) + 8 * (sum != sum)));
    return 0;
}
