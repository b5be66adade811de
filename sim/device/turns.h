/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step (docs/use/device.md), at the end of the server, which owns everything but the lines
 * (mmcs/device/turns.py). Python reads this header, so it holds plain C only.
 *
 * Each thread of a program has a line, a connection on which it says what it waits for (wire.h). Of
 * all of them one runs at a time, in the order of programs and threads; when none can, the machine
 * runs up to what ends a wait first. The same programs: the same run. */
#ifndef MMCS_TURNS_H
#define MMCS_TURNS_H
#pragma GCC visibility push(default)

struct turns {                /* the server reads and writes the first of it */
  int64_t limit;              /* a clock that time does not go past */
  int64_t requests;           /* that have come on lines */
  double silent_s, outside_s; /* of real time, after which `tell` is called */
  int32_t good;               /* no assertion of the model has failed */
  int32_t lines;              /* there are */
  /* The server's: sends the driver's signals and calls turns_signalled(); whether no attached
   * process has the other end of a descriptor; tells why time stands still, or ends no wait. */
  int (*send_signals)(void);
  int (*is_outside)(int pid, int fd);
  void (*tell)(int pid, int why);

  mmcs_sim *sim;
  mmcs_server *server;
  int64_t hz;
  int32_t epoll, bell; /* an eventfd: on some line is a request */
  struct process *processes;
  int64_t numbers, last_process, last_line; /* which ran last */
  struct line *running;
  double began;  /* real time at which it began */
  int64_t clock; /* and the clock */
  int32_t told;
  int64_t events; /* whose signals have been sent */
};

enum turns_why { TURNS_SILENT = 0, TURNS_OUTSIDE = 1, TURNS_EACH_OTHER = 2 };

struct turns *turns_create(mmcs_sim *sim, mmcs_server *server, int epoll);
void turns_destroy(struct turns *t);

/* A program that has been started: nothing goes on before it has come, or ended. */
void turns_expect(struct turns *t, int pid);
/* The processes; their number. */
int turns_pids(const struct turns *t, int32_t *pids, int most);
/* WIRE_LINE has come on this connection, which belongs to the engine from now on, as the eventfd
 * of its answers. page: a file as long as struct wire_page. */
void turns_line(struct turns *t, int fd, int page, int wake, const void *request);
/* 1: the descriptor was a line's or a process', and what it had has been served. */
int turns_hear(struct turns *t, int fd);

/* read(), write() of a process on an open /dev/mc0, as mmcs_sim_read() and mmcs_server_write(). The
 * states of the same read() then come with each sample, and the same write() needs no answer, while
 * neither takes time nor tells of an error or event. */
int turns_read(struct turns *t, int pid, mmcs_client *client, void *states, size_t size);
int turns_write(struct turns *t, int pid, mmcs_client *client, const void *data, size_t size);
/* The client is gone. */
void turns_closes(struct turns *t, const mmcs_client *client);
/* Signals have been sent to a process. */
void turns_signalled(struct turns *t, int pid, uint64_t signals);
/* The machine has run, by a sample or not. */
void turns_passed(struct turns *t, int sampled);

/* A thread runs, or one is on its way; nothing is to be done before a request comes. */
int turns_busy(const struct turns *t);
int turns_rest(const struct turns *t);
/* So many turns: a thread goes on and is served, or time passes. Ends before whatever the server
 * has to do. */
void turns_run(struct turns *t, int turns, int timeout_ms);

#pragma GCC visibility pop
#endif
