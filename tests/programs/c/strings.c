/* Characters: strings, recursion, loops of all kinds, a table of a check sum. */
#include "report.h"

static unsigned crc_table[256];
static char line[80];

static void make_table(void)
{
    unsigned n, c;
    int k;

    for (n = 0; n < 256; n++) {
        c = n;
        for (k = 0; k < 8; k++)
            c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1;
        crc_table[n] = c;
    }
}

static unsigned crc(const char *s)
{
    unsigned c = 0xffffffffu;

    do
        c = crc_table[(c ^ (unsigned)*s) & 255] ^ c >> 8;
    while (*++s);
    return c ^ 0xffffffffu;
}

static int length(const char *s)
{
    const char *p = s;

    while (*p)
        p++;
    return (int)(p - s);
}

static void reverse(char *s, int n)
{
    char c;

    if (n < 2)
        return;
    c = s[0];
    s[0] = s[n - 1];
    s[n - 1] = c;
    reverse(s + 1, n - 2);
}

static char *decimal(char *to, int value)
{
    unsigned magnitude = value < 0 ? -(unsigned)value : (unsigned)value;
    char *p = to;
    int n = 0;

    do {
        to[n++] = (char)('0' + magnitude % 10);
        magnitude /= 10;
    } while (magnitude);
    if (value < 0)
        to[n++] = '-';
    to[n] = 0;
    reverse(p, n);
    return to;
}

int main(void)
{
    static const int values[] = {0, 7, -7, 1000000, -2147483647 - 1, 2147483647};
    int cleared[40] = {0}, i, sum = 0;

    make_table();
    number("crc", crc("123456789"));
    number("length", (unsigned)length("a line of text"));
    for (i = 0; i < 6; i++) {
        text(decimal(line, values[i]));
        putchar(i == 5 ? '\n' : ' ');
    }
    number("table", crc_table[255]);
    for (i = 0; i < 40; i++)
        sum += cleared[i] + i;
    number("cleared", (unsigned)sum);
    return 0;
}
