// Values by name, with listeners for their changes. If a listener fails, the others are still called.

export class Store {
  constructor() {
    this.values = new Map();
    this.listeners = new Map();
  }

  get(name) {
    return this.values.get(name) ?? null;
  }

  set(name, value) {
    this.values.set(name, value);
    for (const listener of this.listeners.get(name) ?? []) {
      try {
        listener(value, name);
      } catch (error) {
        console.error(name, error);
      }
    }
  }

  on(names, listener) {
    for (const name of names.split(" ")) {
      if (!this.listeners.has(name)) this.listeners.set(name, new Set());
      this.listeners.get(name).add(listener);
    }
    return listener;
  }
}
