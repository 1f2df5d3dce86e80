// cosplat-player: head avatars and splats in the browser. Importing it defines the elements
// <cosplat-avatar> and <cosplat-splats>.
export { Avatar, openAvatar } from "./avatar.js";
export { AvatarElement, configure, SplatsElement } from "./elements.js";
export { setGpuRenderer } from "./gpu.js";
export { CosplatError, threadsAvailable } from "./module.js";
export { RemoteAvatar, RemoteScene } from "./remote.js";
export { openScene, Scene } from "./scene.js";
