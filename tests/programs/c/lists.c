/* Memory: a list on the heap, sorting through a pointer to a function, structures by value, statics. */
#include "report.h"
extern void *malloc(unsigned long);
extern void free(void *);

struct node {
    int key;
    struct node *next;
};
struct pair {
    int small, large;
    struct pair *self;
};

static int table[] = {5, -3, 99, 0, 42, -100, 7, 7, 1};
static int counts[16];
static int calls = 3;
static const char *const names[] = {"zero", "one", "many"};

static int rising(int a, int b) { calls++; return a - b; }
static int falling(int a, int b) { calls++; return b - a; }

static void sort(int *a, int n, int (*order)(int, int))
{
    int i, k, v;

    for (i = 1; i < n; i++) {
        v = a[i];
        for (k = i; k > 0 && order(a[k - 1], v) > 0; k--)
            a[k] = a[k - 1];
        a[k] = v;
    }
}

static struct pair bounds(const int *a, int n)
{
    struct pair p;
    int i;

    p.small = p.large = a[0];
    p.self = 0;
    for (i = 1; i < n; i++) {
        if (a[i] < p.small)
            p.small = a[i];
        if (a[i] > p.large)
            p.large = a[i];
    }
    return p;
}

static int ackermann(int m, int n)
{
    return m == 0 ? n + 1 : n == 0 ? ackermann(m - 1, 1) : ackermann(m - 1, ackermann(m, n - 1));
}

static const char *name(int n)
{
    switch (n) {
    case 0: return names[0];
    case 1: return names[1];
    case 17: return "seventeen";
    case 18: case 19: case 20: return "about twenty";
    case -5: return "minus five";
    default: return names[2];
    }
}

int main(void)
{
    struct node *list = 0, *n;
    struct pair found;
    int size = sizeof table / sizeof table[0], i, sum = 0;

    sort(table, size, rising);
    for (i = 0; i < size; i++)
        number("up", (unsigned)table[i]);
    sort(table, size, falling);
    number("first", (unsigned)table[0]);
    found = bounds(table, size);
    number("small", (unsigned)found.small);
    number("large", (unsigned)found.large);
    number("calls", (unsigned)calls);
    for (i = 0; i < 50; i++) {
        n = malloc(sizeof *n);
        if (!n)
            return 1;
        n->key = i * i;
        n->next = list;
        list = n;
        counts[i & 15]++;
    }
    while (list) {
        sum = sum * 3 + list->key;
        n = list->next;
        free(list);
        list = n;
    }
    number("list", (unsigned)sum);
    for (i = 0; i < 16; i++)
        sum += counts[i] << i;
    number("counts", (unsigned)sum);
    number("ackermann", (unsigned)ackermann(2, 6));
    for (i = -6; i < 22; i += 5) {
        text(name(i));
        putchar('\n');
    }
    text(name(17));
    text(name(20));
    putchar('\n');
    return 0;
}
