// @ts-check
// The connection: one WebSocket for the tab. It comes back by itself, acknowledges frames after they have been drawn, and asks for
// less while nobody looks.

const SHORTEST_PAUSE = 500, LONGEST_PAUSE = 5000;

export class Link {
  /** @param {import("./store.js").Store} store */
  constructor(store) {
    this.store = store;
    this.streams = "";
    this.pause = SHORTEST_PAUSE;
    this.next = 1;
    /** Orders without a reply. @type {Map<number, (problem: string | null) => void>} */
    this.pending = new Map();
    this.unacknowledged = 0;
    document.addEventListener("visibilitychange", () => this.subscribe(this.wanted ?? { streams: [] }));
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/live`);
    this.socket = socket;
    socket.onmessage = (event) => this.receive(JSON.parse(event.data));
    socket.onclose = () => {
      this.store.disconnected();
      this.onlost?.();
      for (const done of this.pending.values()) done("the connection was lost: it is not known whether this was carried out");
      this.pending.clear();
      setTimeout(() => this.connect(), this.pause * (0.75 + Math.random() / 2));
      this.pause = Math.min(this.pause * 2, LONGEST_PAUSE);
    };
  }

  receive(message) {
    switch (message.type) {
      case "hello":
        this.pause = SHORTEST_PAUSE;
        this.streams = "";
        this.store.connected(message);
        this.subscribe(this.wanted ?? { streams: [] });
        break;
      case "frame":
        this.store.frame(message);
        if (message.ack) this.unacknowledged = message.seq;
        // a tab that is not drawn does not ask for more than it has asked for
        if (document.hidden) this.acknowledge();
        break;
      case "moment":
        this.store.moment(message);
        this.onmoment?.();
        break;
      case "guards":
        this.store.explain(message);
        break;
      case "armed":
        this.onarmed?.(null);
        break;
      case "done": case "problem": {
        const problem = message.type === "done" ? null : message.text;
        const done = this.pending.get(message.id);
        this.pending.delete(message.id);
        if (done) done(problem); else this.onarmed?.(problem);
      }
    }
  }

  /** Called after a frame has been drawn. */
  acknowledge() {
    if (this.unacknowledged) this.send({ type: "ack", seq: this.unacknowledged });
    this.unacknowledged = 0;
  }

  /** Replaces the subscriptions: streams and outputs, outputs of which every sample is wanted, and the part of the log; null for all of it.
   * @param {{ streams: string[], every?: string[], log?: any }} wanted @returns {boolean} whether they are others than before */
  subscribe(wanted) {
    this.wanted = wanted;
    const { streams, every = [], log = null } = wanted;
    const max_hz = document.hidden ? 1 : this.store.rate;
    const request = JSON.stringify({ type: "subscribe", streams, every, log, max_hz });
    if (request === this.streams || this.socket?.readyState !== WebSocket.OPEN) return false;
    this.streams = request;
    this.socket.send(request);
    return true;
  }

  send(message) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Sends an order or a message. @returns {Promise<string | null>} the problem, if there is one */
  order(message) {
    const id = this.next++;
    return new Promise((resolve) => {
      if (!this.send({ ...message, id })) return resolve("there is no connection");
      this.pending.set(id, resolve);
    });
  }
}
