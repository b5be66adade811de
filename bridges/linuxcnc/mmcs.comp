// SPDX-License-Identifier: Apache-2.0
// LinuxCNC's side of the bridge: the axes of a machine as HAL pins. docs/use/linuxcnc.md
component mmcs "MMCS axes: a position or velocity servo of its own behind each pin";
description """
Speaks with bridges/linuxcnc/machine.py over a local socket, one exchange for each period of the
thread. mmcs.read takes what the last period gave, mmcs.write hands on the commands, by which the
machine lives through the next one. Add read before the motion controller, write after it.""";

pin in float position-cmd.#[32:personality] "where the axis is to be, units";
pin in float velocity-cmd.#[32:personality] "how fast, units/s, where the servo is one of velocity";
pin out float position-fb.#[32:personality] "where the encoder says that it is, units";
pin out float velocity-fb.#[32:personality] "how fast it moves: the difference of that, units/s";
pin out bit velocity-mode.#[32:personality] "the axis follows velocity-cmd, not position-cmd";
pin io bit index-enable.#[32:personality] "at the next index the count becomes 0, and this false";
pin out bit amp-fault.#[32:personality] "the servo is off though it should be on";
pin out float current.#[32:personality] "what the D/A was told, V";
param rw float scale.#[32:personality] = 1.0 "encoder counts per unit, not 0";
pin in bit enable "rising: MENABLE, falling: MSTOP";
pin in bit estop-ok-in "the host's contact in the e-stop loop; false opens it as the button does";
pin out bit estop-ok-out "no fault since the last rising enable: to the host's emc-enable-in";
pin out bit enabled "the servo drives the motors";
pin out bit panic "the PANIC line of the machine; high, too, while it is at rest";
pin out bit brakes-released;
pin out float machine-time "seconds of the machine's time";
pin out u32 lost = 0 "periods in which the machine did not answer";

option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
modparam dummy path "socket of the machine, as machine.py was told by --path";
function read "takes the answer to the last write";
function write "commands for the next period";
variable int waiting;
include <errno.h>;
include <string.h>;
include <sys/socket.h>;
include <sys/time.h>;
include <sys/un.h>;
license "Apache-2.0";
author "MMCS";
;;

#define AXES 32
#define MAGIC 0x3148434Du /* MCH1 */
#define PATIENCE_S 10     /* MENABLE included */

enum { ENABLE = 1, ESTOP_OK = 2 };
enum { FAULT = 1, ENABLED = 2, PANIC = 4, RELEASED = 8 };
enum { INDEX_WANTED = 1 };
enum { AMP_FAULT = 1, INDEX_SEEN = 2, VELOCITY = 4 };

/* bridges/linuxcnc/machine.py has the same. */
struct command {
  unsigned magic, flags;
  long long period_ns;
  struct {
    double position, velocity; /* counts, counts/s */
    unsigned flags, unused;
  } axis[AXES];
};
struct answer {
  unsigned magic, flags;
  double time;
  struct {
    double position, velocity, volts;
    unsigned flags, unused;
  } axis[AXES];
};

static char *path = "/tmp/mmcs-hal.sock";
RTAPI_MP_STRING(path, "socket of bridges/linuxcnc/machine.py");

static int line = -1;
extern int close(int); /* unistd.h has other functions of the names read and write */

EXTRA_SETUP() {
  struct sockaddr_un at = {.sun_family = AF_UNIX};
  struct timeval patience = {PATIENCE_S, 0};
  (void)__comp_inst;
  (void)prefix;
  (void)extra_arg;
  if (personality < 1 || personality > AXES) {
    rtapi_print_msg(RTAPI_MSG_ERR, "mmcs: personality=%d: the number of axes, 1 to %d\n",
                    personality, AXES);
    return -EINVAL;
  }
  if (strlen(path) >= sizeof at.sun_path) {
    rtapi_print_msg(RTAPI_MSG_ERR, "mmcs: path=%s: this name is too long for a socket\n", path);
    return -EINVAL;
  }
  strcpy(at.sun_path, path);
  line = socket(AF_UNIX, SOCK_SEQPACKET, 0);
  if (line < 0 || connect(line, (struct sockaddr *)&at, sizeof at) != 0) {
    rtapi_print_msg(RTAPI_MSG_ERR, "mmcs: path=%s: %s; start bridges/linuxcnc/machine.py first\n",
                    path, strerror(errno));
    return -ENXIO;
  }
  (void)setsockopt(line, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  return 0;
}

EXTRA_CLEANUP() {
  if (line >= 0) close(line);
}

FUNCTION(write) {
  struct command c = {.magic = MAGIC};
  if (line < 0) return;
  c.period_ns = period;
  c.flags = (enable ? ENABLE : 0) | (estop_ok_in ? ESTOP_OK : 0);
  for (int n = 0; n < personality; n++) {
    c.axis[n].position = position_cmd(n) * scale(n);
    c.axis[n].velocity = velocity_cmd(n) * scale(n);
    c.axis[n].flags = index_enable(n) ? INDEX_WANTED : 0;
  }
  waiting = send(line, &c, sizeof c, MSG_NOSIGNAL) == sizeof c;
  if (!waiting) lost++;
}

FUNCTION(read) {
  struct answer a;
  if (!waiting) return;
  waiting = 0;
  if (recv(line, &a, sizeof a, 0) != sizeof a || a.magic != MAGIC) {
    /* Nobody there any more: what was measured last is no measurement, and the host must know. */
    if (lost++ == 0) rtapi_print_msg(RTAPI_MSG_ERR, "mmcs: the machine does not answer\n");
    estop_ok_out = enabled = 0;
    for (int n = 0; n < personality; n++) amp_fault(n) = 1;
    return;
  }
  estop_ok_out = !(a.flags & FAULT);
  enabled = !!(a.flags & ENABLED);
  panic = !!(a.flags & PANIC);
  brakes_released = !!(a.flags & RELEASED);
  machine_time = a.time;
  for (int n = 0; n < personality; n++) {
    double counts = scale(n) != 0 ? scale(n) : 1.0;
    position_fb(n) = a.axis[n].position / counts;
    velocity_fb(n) = a.axis[n].velocity / counts;
    current(n) = a.axis[n].volts;
    amp_fault(n) = !!(a.axis[n].flags & AMP_FAULT);
    velocity_mode(n) = !!(a.axis[n].flags & VELOCITY);
    if (a.axis[n].flags & INDEX_SEEN) index_enable(n) = 0;
  }
}
