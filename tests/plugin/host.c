/* The smallest host: opens an avatar, lets it smile at the camera, writes one frame as an image
 * (PAM, which most viewers show).
 *
 *   cc host.c $(pkg-config --cflags --libs cosplat) -o host
 *   ./host avatar.glb flame.pkl frame.pam */
#include <cosplat.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 256, HEIGHT = 256 };

static int fail(const char* what, cosplat_avatar* avatar) {
  fprintf(stderr, "%s: %s\n", what, cosplat_last_error(avatar));
  cosplat_close(avatar);
  return 1;
}

int main(int argc, char** argv) {
  static uint8_t pixels[4 * WIDTH * HEIGHT];
  cosplat_open_options options = {0};
  cosplat_parameters parameters = {0};
  cosplat_picture picture = {0};
  cosplat_avatar* avatar = NULL;

  if (argc != 4) {
    fprintf(stderr, "usage: %s avatar.glb flame-model frame.pam\n", argv[0]);
    return 2;
  }
  if (cosplat_version() < COSPLAT_VERSION) {
    fprintf(stderr, "libcosplat %s is older than this program\n", cosplat_version_text());
    return 1;
  }

  options.struct_size = sizeof(options);
  options.flame_path = argv[2];
  if (cosplat_open(argv[1], &options, &avatar)) return fail("cannot open the avatar", NULL);

  parameters.struct_size = sizeof(parameters);
  if (cosplat_get_parameters(avatar, &parameters)) return fail("no parameters", avatar);
  parameters.time_ns = 0;
  parameters.joints[COSPLAT_JOINT_JAW][0] = 0.1f; /* opens the mouth a little */
  if (cosplat_set_parameters(avatar, &parameters)) return fail("bad parameters", avatar);
  if (cosplat_set_expression(avatar, 0, 1.0f, 0)) return fail("bad expression", avatar);

  picture.struct_size = sizeof(picture);
  picture.width = WIDTH;
  picture.height = HEIGHT;
  picture.pixels = pixels;
  if (cosplat_render(avatar, &picture)) return fail("cannot draw", avatar);
  cosplat_close(avatar);

  FILE* file = fopen(argv[3], "wb");
  if (!file) return fail("cannot write the frame", NULL);
  fprintf(file,
          "P7\nWIDTH %d\nHEIGHT %d\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n",
          WIDTH,
          HEIGHT);
  fwrite(pixels, 1, sizeof(pixels), file);
  return fclose(file) ? 1 : 0;
}
