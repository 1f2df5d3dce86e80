/**
 * Lets PlayCanvas' engine draw the splats on the GPU where that is measured to be faster, or where an
 * element has renderer="gpu". Before the first element is shown. playcanvas: the module, of the page's
 * own; deviceTypes: of its createGraphicsDevice, by default WebGPU, else WebGL 2.
 */
export function usePlayCanvas(playcanvas: object, options?: { deviceTypes?: string[] }): void;
