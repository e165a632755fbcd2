/* Defects of the process: what an FMU copies, starts, writes to and leaves behind in a step, and while it is loaded. */

#include <pthread.h>
#include <unistd.h>

#ifdef DEFECT_LEAVES_A_THREAD
static void *idle(void *nothing) {
    for (;;) usleep(1000); /* also when the library is unloaded */
    return nothing;
}
#endif

#ifdef DEFECT_LOADS_SLOWLY
__attribute__((constructor)) static void load(void) { usleep(400000); }
#endif

static void disturb_process(int *count) {
    (void)count;
#ifdef DEFECT_LEAVES_A_PROCESS
    if (*count == 5 && fork() == 0) {
        setsid();
        sleep(60);
        _exit(0);
    }
#endif
#ifdef DEFECT_LEAVES_A_DAEMON
    char *nothing[] = {NULL}, *sleeper[] = {"sleep", "601", NULL};
    if (*count == 5 && fork() == 0) {
        setsid();
        if (fork() == 0) execve("/bin/sleep", sleeper, nothing);
        _exit(0);
    }
#endif
#ifdef DEFECT_WRITES_TO_DESCRIPTORS
    for (int k = 3; k < 64; k++) {
        if (*count % 5 == 0 && write(k, "", 1) < 0) continue;
    }
#endif
#ifdef DEFECT_RETURNS_TWICE
    if (*count == 5 && fork() == 0) *count += 100; /* both processes return from this step */
#endif
#ifdef DEFECT_LEAVES_A_THREAD
    pthread_t thread;
    if (*count == 5 && pthread_create(&thread, NULL, idle, NULL) == 0) pthread_detach(thread);
#endif
}
