// The worker of the offline page: with the module's glue in it, since a page of a file may not load
// other files.
import player from "../dist/player.mjs";

globalThis.cosplatGlue = { default: player };
import("../src/worker.js");
