/* Preloaded into Wine's server: what it frees is given back later, unchanged until then.

   The server of Wine 8 keeps a finished input or output of a socket until the thread that began it looks. When another
   thread closes the socket meanwhile, the server then wakes who waits for a socket that it has freed (async_set_result
   by way of fd->user): nobody does, the list of waiters was empty when it was freed. As long as the memory has not been
   used again, that is what it finds; otherwise it crashes. */

extern void __libc_free(void *memory); /* of glibc */

#define KEPT 65536

static void *kept[KEPT]; /* a ring */
static unsigned oldest;

void free(void *memory)
{
    void *due;

    if (!memory) return;
    due = kept[oldest];
    kept[oldest] = memory;
    oldest = (oldest + 1) % KEPT;
    __libc_free(due);
}
