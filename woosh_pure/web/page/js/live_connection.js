// The WebSocket to the server: connects again after a break, acknowledges each frame, and queues nothing.

const RECONNECT_SECONDS = [0.3, 0.6, 1, 2, 3]; // seconds between attempts
const BROKEN_SECONDS = 6; // seconds without a message after which the connection counts as broken

export class LiveConnection {
  // handlers: text(message), binary(buffer), state("open" | "closed", code)
  constructor(address, handlers) {
    this.address = address;
    this.handlers = handlers;
    this.socket = null;
    this.attempts = 0;
    this.heardAt = null;
    this.began = 0;
    this.frames = 0; // handled on this socket
    this.timer = null;
    setInterval(() => this.look(), 1000);
  }

  get open() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  get buffered() {
    return this.socket?.bufferedAmount ?? 0;
  }

  connect() {
    const socket = new WebSocket(this.address());
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.began = seconds();
    this.frames = 0;
    socket.onopen = () => {
      this.attempts = 0;
      this.heardAt = seconds();
      this.handlers.state("open");
    };
    socket.onmessage = (event) => this.heard(socket, event.data);
    socket.onclose = (event) => {
      if (this.socket === socket) this.again(event.code);
    };
  }

  heard(socket, data) {
    if (socket !== this.socket) return;
    this.heardAt = seconds();
    try {
      if (typeof data === "string") this.handlers.text(JSON.parse(data));
      else this.handlers.binary(data);
    } catch (error) {
      console.error(error); // skip a bad frame
    }
    this.frames += 1;
    this.send({ t: "ack", n: this.frames });
  }

  // Send now or not at all: a message that waits through a break would be out of date.
  send(message) {
    if (!this.open) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  again(code) {
    this.socket = null;
    this.handlers.state("closed", code);
    clearTimeout(this.timer);
    const wait = RECONNECT_SECONDS[Math.min(this.attempts, RECONNECT_SECONDS.length - 1)];
    this.attempts += 1;
    this.timer = setTimeout(() => this.connect(), wait * 1000);
  }

  // Connect now instead of after the pause.
  hurry() {
    if (this.socket !== null) return;
    clearTimeout(this.timer);
    this.connect();
  }

  // Detect a dead connection that was not closed, or an attempt that hangs.
  look() {
    const socket = this.socket;
    if (socket === null || document.hidden) return;
    const since = socket.readyState === WebSocket.OPEN ? this.heardAt : this.began;
    if (seconds() - since > BROKEN_SECONDS) {
      socket.onclose = null;
      socket.close();
      this.again(1006);
    }
  }
}

export const seconds = () => performance.now() / 1000;

// Look every 50 ms whether `met()`, for at most `limit` seconds.
export async function until(met, limit) {
  const end = seconds() + limit;
  while (!met() && seconds() < end) await new Promise((done) => setTimeout(done, 50));
}
