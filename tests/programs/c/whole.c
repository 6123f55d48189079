/* Whole numbers: every operator on edges and a sequence, of 32 and of 64 bits. */
#include "report.h"

static const unsigned edges[] = {0, 1, 2, 3, 7, 10, 255, 65535, 65536, 0x7fffffffu, 0x80000000u, 0x80000001u, 0xfffffff9u, 0xffffffffu};
#define EDGES (int)(sizeof edges / sizeof edges[0])

static unsigned mix(unsigned sum, unsigned value)
{
    return (sum << 5 | sum >> 27) ^ value;
}

static unsigned words(unsigned a, unsigned b)
{
    unsigned sum = 0;
    int i = (int)a, k = (int)b;

    sum = mix(sum, a + b);
    sum = mix(sum, a - b);
    sum = mix(sum, a * b);
    sum = mix(sum, a & b);
    sum = mix(sum, (a | b) ^ ~a);
    sum = mix(sum, a << (b & 31));
    sum = mix(sum, a >> (b & 31));
    sum = mix(sum, (unsigned)(i >> (int)(b & 31)));
    sum = mix(sum, (unsigned)((a < b) + 2 * (i < k) + 4 * (a == b) + 8 * (i >= k) + 16 * (a <= b)));
    if (b) {
        sum = mix(sum, a / b);
        sum = mix(sum, a % b);
        if (!(a == 0x80000000u && b == 0xffffffffu)) {
            sum = mix(sum, (unsigned)(i / k));
            sum = mix(sum, (unsigned)(i % k));
        }
    }
    return sum;
}

/* Not through an array: GCC 2.95's C4x port at -O2 takes the upper half of an element that it steps past from the wrong word. */
static unsigned mix_both(unsigned sum, unsigned long long value)
{
    return mix(mix(sum, (unsigned)value), (unsigned)(value >> 32));
}

static unsigned double_words(unsigned long long a, unsigned long long b)
{
    unsigned sum = 0;

    sum = mix_both(sum, a + b);
    sum = mix_both(sum, a - b);
    sum = mix_both(sum, a * b);
    sum = mix_both(sum, (a & b) ^ (a | ~b));
    if (b) {
        sum = mix_both(sum, a / b);
        sum = mix_both(sum, a % b);
        if (b != ~0ull) {
            sum = mix_both(sum, (unsigned long long)((long long)a / (long long)b));
            sum = mix_both(sum, (unsigned long long)((long long)a % (long long)b));
        }
    }
    return mix(sum, (a < b) + 2 * ((long long)a < (long long)b) + 4 * (a == b));
}

int main(void)
{
    unsigned sum = 0, wide = 0, seed = 12345;
    int i, k;

    for (i = 0; i < EDGES; i++)
        for (k = 0; k < EDGES; k++) {
            sum = mix(sum, words(edges[i], edges[k]));
            wide = mix(wide, double_words((unsigned long long)edges[i] << 32 | edges[k], (unsigned long long)edges[k] << (i & 31) | edges[i]));
        }
    number("edges", sum);
    number("wide", wide);
    for (i = 0; i < 200; i++) {
        seed = seed * 1664525u + 1013904223u;
        sum = mix(sum, words(seed, seed * 69069u >> (i & 31)));
    }
    number("sequence", sum);
    return 0;
}
