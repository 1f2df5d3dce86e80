// What a closed tab goes on from: files by their paths, in this browser (IndexedDB).
const NAME = "cosplat-studio", FILES = "files";

const done = (request) =>
  new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });

export class Store {
  static async open() {
    const request = indexedDB.open(NAME, 1);
    request.onupgradeneeded = () => request.result.createObjectStore(FILES);
    const store = new Store();
    store.database = await done(request);
    return store;
  }
  files(mode) {
    return this.database.transaction(FILES, mode).objectStore(FILES);
  }
  async put(path, bytes) {
    await done(this.files("readwrite").put(bytes, path));
  }
  async get(path) {
    return done(this.files("readonly").get(path));
  }
  // [{path, bytes}] of all below a folder.
  async all(folder) {
    const range = IDBKeyRange.bound(folder, `${folder}\uffff`);
    const [paths, contents] = await Promise.all([
      done(this.files("readonly").getAllKeys(range)),
      done(this.files("readonly").getAll(range)),
    ]);
    return paths.map((path, i) => ({ path, bytes: contents[i] }));
  }
  async remove(path) {
    await done(this.files("readwrite").delete(path));
  }
  async clear() {
    await done(this.files("readwrite").clear());
  }
}
