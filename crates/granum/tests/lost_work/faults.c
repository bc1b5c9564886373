/* A disk and a clock that fail as a seed decides, put between a program and the system: compiled by a test and loaded with LD_PRELOAD.
 *
 * FAULTS_SEED      with it, one in FAULTS_ONE_IN operations on files below FAULTS_BELOW fails: a write, in whole or in part, the flushing of
 *                  a file, a renaming; and the clock of the day jumps by up to ten years at each look. Each fault adds a letter to the file
 *                  FAULTS_LOG. The faults of a process follow from the seed and from its arguments.
 * FAULTS_FLOCK     "deaf": locks are granted to everybody, as between the machines of a cluster whose file system has locks within a
 *                  machine only; "missing": there are none.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static atomic_uint_fast64_t state;
static const char *below, *flock_mode;
static long one_in;
static int log_file = -1;

__attribute__((constructor)) static void begin(void) {
  flock_mode = getenv("FAULTS_FLOCK");
  const char *seed = getenv("FAULTS_SEED");
  if (!seed) return;
  uint64_t mixed = 1469598103934665603u ^ strtoull(seed, NULL, 10);
  char words[4096];
  int file = open("/proc/self/cmdline", O_RDONLY);
  ssize_t count = file < 0 ? 0 : read(file, words, sizeof words);
  if (file >= 0) close(file);
  for (ssize_t k = 0; k < count; k++) mixed = (mixed ^ (unsigned char)words[k]) * 1099511628211u;
  state = mixed;
  below = getenv("FAULTS_BELOW");
  one_in = atol(getenv("FAULTS_ONE_IN"));
  log_file = open(getenv("FAULTS_LOG"), O_WRONLY | O_CREAT | O_APPEND, 0644);
}

static uint64_t draw(uint64_t most) {
  uint64_t k = atomic_fetch_add(&state, 0x9e3779b97f4a7c15u);
  k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9u;
  k = (k ^ (k >> 27)) * 0x94d049bb133111ebu;
  return (k ^ (k >> 31)) % most;
}

static int fails(const char *path, char letter) {
  if (!below || !path || strncmp(path, below, strlen(below)) != 0 || draw(one_in) != 0) return 0;
  syscall(SYS_write, log_file, &letter, 1);
  return 1;
}

static int file_fails(int file, char letter) {
  if (!below) return 0;
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return 0;
  path[length] = 0;
  return fails(path, letter);
}

ssize_t write(int file, const void *bytes, size_t count) {
  if (count > 0 && file_fails(file, 'w')) {
    if (draw(2)) {
      errno = draw(2) ? ENOSPC : EIO;
      return -1;
    }
    count = draw(count) + (count == 1);
    if (count == 0) count = 1;
  }
  return syscall(SYS_write, file, bytes, count);
}

int fsync(int file) {
  if (file_fails(file, 's')) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_fsync, file);
}

int fdatasync(int file) { return fsync(file); }

int rename(const char *from, const char *to) {
  char path[4096];
  const char *whole = from[0] == '/' ? from : realpath(from, path);
  if (fails(whole, 'r')) {
    errno = EIO;
    return -1;
  }
  return syscall(SYS_rename, from, to);
}

int clock_gettime(clockid_t clock, struct timespec *time) {
  int result = syscall(SYS_clock_gettime, clock, time);
  if (below && clock == CLOCK_REALTIME && result == 0) time->tv_sec += (long)draw(630720000) - 315360000;
  return result;
}

int flock(int file, int operation) {
  if (flock_mode && strcmp(flock_mode, "deaf") == 0) return 0;
  if (flock_mode && strcmp(flock_mode, "missing") == 0) {
    errno = ENOLCK;
    return -1;
  }
  return syscall(SYS_flock, file, operation);
}
