/* What the programs of this folder print with: the host's C library, or that of c40_programs/lib. */
extern int putchar(int c);

static void text(const char *s)
{
    while (*s)
        putchar(*s++);
}

/* In hexadecimal, as 32 bits whatever the machine. */
static void number(const char *name, unsigned value)
{
    int shift;

    text(name);
    putchar(' ');
    for (shift = 28; shift >= 0; shift -= 4)
        putchar("0123456789abcdef"[value >> shift & 15]);
    putchar('\n');
}
