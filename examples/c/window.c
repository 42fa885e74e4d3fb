/* A window in which a camera flies over a server's terrain: SDL2 and OpenGL 3.3 over the C interface.
 *   window ws://127.0.0.1:8080 [SECONDS [PICTURE.ppm]]
 * Without SECONDS until the window is closed. It says at the end what it has drawn, and exits 1 if that had no ground. */
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <SDL2/SDL.h>
#include <foreland.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 960, HEIGHT = 540, CHANNELS = 5, TRIANGLES = 4 };
static const double kFovY = 0.9, kPitch = -0.45, kSpeed = 60, kNear = 5, kFar = 3e5;

/* An array of the mesh as we hold it, and its buffer on the graphics card. */
typedef struct {
  GLuint buffer, target;
  size_t element, capacity; /* bytes of an element; elements that the buffer has room for */
  char* data;
} Array;

/* The terrain, or all objects. */
typedef struct {
  GLuint vertex_array;
  GLsizei index_count;
  Array arrays[CHANNELS];
} Mesh;

static const char* kVertex =
    "#version 330 core\n"
    "layout(location = 0) in vec4 from; layout(location = 1) in vec4 to;\n"
    "layout(location = 2) in vec4 from_normal; layout(location = 3) in vec4 to_normal;\n"
    "uniform mat4 view; uniform float weight; out vec3 normal; out float height;\n"
    "void main() {\n"
    "  normal = mix(from_normal, to_normal, weight).xyz, height = mix(from, to, weight).w;\n"
    "  gl_Position = view * vec4(mix(from, to, weight).xyz, 1);\n"
    "}\n";
static const char* kFragment =
    "#version 330 core\n"
    "in vec3 normal; in float height; uniform vec2 heights; out vec4 colour;\n"
    "void main() {\n"
    "  float light = 0.25 + 0.75 * max(0.0, dot(normalize(normal), normalize(vec3(-1, 1, 1))));\n"
    "  float share = clamp((height - heights.x) / max(1.0, heights.y - heights.x), 0.0, 1.0);\n"
    "  colour = vec4(light * mix(vec3(0.25, 0.45, 0.2), vec3(0.95, 0.92, 0.9), share), 1);\n"
    "}\n";

static void quit(const char* what, const char* why) {
  fprintf(stderr, "window: %s: %s\n", what, why), exit(2);
}

static GLuint makeProgram(void) {
  const GLuint program = glCreateProgram();
  const char* sources[2] = {kVertex, kFragment};
  char log[512] = "";
  for (int i = 0; i < 2; ++i) {
    const GLuint shader = glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
    glShaderSource(shader, 1, &sources[i], NULL), glCompileShader(shader), glAttachShader(program, shader);
  }
  GLint is_linked = 0;
  glLinkProgram(program), glGetProgramiv(program, GL_LINK_STATUS, &is_linked), glGetProgramInfoLog(program, sizeof log, NULL, log);
  return is_linked ? program : (quit("shaders", log), 0);
}

static void makeMesh(Mesh* mesh) {
  const size_t elements[CHANNELS] = {16, 16, 4, 4, 12};
  glGenVertexArrays(1, &mesh->vertex_array), glBindVertexArray(mesh->vertex_array);
  for (GLuint i = 0; i < CHANNELS; ++i) {
    Array* array = &mesh->arrays[i];
    array->element = elements[i];
    array->target = i == TRIANGLES ? GL_ELEMENT_ARRAY_BUFFER : GL_ARRAY_BUFFER;
    glGenBuffers(1, &array->buffer), glBindBuffer(array->target, array->buffer);
    if (i != TRIANGLES) glEnableVertexAttribArray(i), glVertexAttribPointer(i, 4, i < 2 ? GL_FLOAT : GL_BYTE, i >= 2, 0, NULL);
  }
}

/* Brings an array to what an update says of it: the ranges that change, or all where there was no room. */
static void apply(Array* array, const ForelandChannel* channel) {
  const size_t size = array->element;
  const int grows = channel->count > array->capacity;
  const char* from = channel->data;
  glBindBuffer(array->target, array->buffer);
  if (grows) {
    array->capacity = channel->count + channel->count / 2;
    array->data = realloc(array->data, array->capacity * size);
    if (!array->data) quit("memory", "there is not enough");
  }
  for (uint32_t i = 0; i < channel->range_count; ++i) {
    const size_t begin = channel->ranges[2 * i] * size, bytes = channel->ranges[2 * i + 1] * size - begin;
    memcpy(array->data + begin, from, bytes);
    if (!grows) glBufferSubData(array->target, (GLintptr)begin, (GLsizeiptr)bytes, from);
    from += bytes;
  }
  if (grows) glBufferData(array->target, (GLsizeiptr)(array->capacity * size), array->data, GL_DYNAMIC_DRAW);
}

static void applyPart(Mesh* mesh, const ForelandPart* part) {
  const ForelandChannel* channels[CHANNELS] = {&part->from_positions, &part->to_positions, &part->from_normals, &part->to_normals, &part->triangles};
  glBindVertexArray(mesh->vertex_array);
  for (int i = 0; i < CHANNELS; ++i) apply(&mesh->arrays[i], channels[i]);
  mesh->index_count = (GLsizei)(3 * part->triangles.count);
}

/* From positions about the mesh's origin to the screen, by columns. What is large is subtracted in doubles. */
static void viewMatrix(const ForelandPose* pose, const double origin[3], float out[16]) {
  const double *q = pose->orientation, x = q[0], y = q[1], z = q[2], w = q[3];
  const double axes[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)}, /* the camera's x, y, z in the scene */
                             {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                             {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
  const double focal = 1 / tan(kFovY / 2), deep = (kFar + kNear) / (kNear - kFar), shift = 2 * kFar * kNear / (kNear - kFar);
  for (int column = 0; column < 4; ++column) {
    double at[3] = {0, 0, 0}; /* in the camera's axes */
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) at[i] += axes[i][k] * (column < 3 ? k == column : origin[k] - pose->eye[k]);
    out[4 * column] = (float)(at[0] * focal * HEIGHT / WIDTH);
    out[4 * column + 1] = (float)(at[1] * focal);
    out[4 * column + 2] = (float)(at[2] * deep + (column == 3 ? shift : 0));
    out[4 * column + 3] = (float)-at[2];
  }
}

/* Eastward over the middle of the scene and back, looking down a little. */
static ForelandPose poseAt(const ForelandScene* scene, double seconds) {
  const double way = 0.8 * (scene->high[0] - scene->low[0]), gone = fmod(kSpeed * seconds, 2 * way), pitch = 0.5 * (1.5707963267948966 + kPitch);
  const double yaw = gone < way ? -0.7853981633974483 : 0.7853981633974483; /* half of it */
  ForelandPose pose = {{scene->low[0] + 0.125 * way + (gone < way ? gone : 2 * way - gone), 0.5 * (scene->low[1] + scene->high[1]), scene->high[2] + 100},
                       {cos(yaw) * sin(pitch), sin(yaw) * sin(pitch), sin(yaw) * cos(pitch), cos(yaw) * cos(pitch)}};
  return pose;
}

/* The share of the picture that is no sky; keeps the picture if there is a file for it. */
static double groundShare(const char* file) {
  static unsigned char pixels[HEIGHT][WIDTH][3];
  size_t ground = 0;
  glPixelStorei(GL_PACK_ALIGNMENT, 1), glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, pixels);
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) ground += pixels[y][x][2] < 250; /* the sky is as blue as can be */
  FILE* out = file ? fopen(file, "wb") : NULL;
  if (out) fprintf(out, "P6 %d %d 255\n", WIDTH, HEIGHT);
  for (int y = HEIGHT; out && y-- > 0;) fwrite(pixels[y], sizeof pixels[y], 1, out);
  if (out) fclose(out);
  return (double)ground / (WIDTH * HEIGHT);
}

static SDL_Window* makeWindow(void) {
  if (SDL_Init(SDL_INIT_VIDEO) != 0) quit("SDL", SDL_GetError());
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 3), SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
  SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE), SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 24);
  SDL_Window* window = SDL_CreateWindow("Foreland", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, WIDTH, HEIGHT, SDL_WINDOW_OPENGL);
  if (!window || !SDL_GL_CreateContext(window)) quit("OpenGL 3.3", SDL_GetError());
  SDL_GL_SetSwapInterval(1), glEnable(GL_DEPTH_TEST), glEnable(GL_CULL_FACE), glClearColor(0.6f, 0.8f, 1, 1);
  return window;
}
static void draw(GLuint program, const Mesh meshes[2], const ForelandFrame* frame, const ForelandUpdate* update, const ForelandScene* scene) {
  float view[16];
  viewMatrix(&frame->pose, update->origin, view), glUseProgram(program);
  glUniformMatrix4fv(glGetUniformLocation(program, "view"), 1, GL_FALSE, view);
  glUniform1f(glGetUniformLocation(program, "weight"), (float)frame->weight);
  glUniform2f(glGetUniformLocation(program, "heights"), (float)scene->lowest, (float)scene->highest);
  for (int i = 0; i < 2; ++i)
    glBindVertexArray(meshes[i].vertex_array), glDrawElements(GL_TRIANGLES, meshes[i].index_count, GL_UNSIGNED_INT, NULL);
}

int main(int argc, char** argv) {
  const double seconds = argc > 2 ? atof(argv[2]) : INFINITY;
  ForelandTerrain* terrain = NULL;
  if (foreland_open(argc > 1 ? argv[1] : "ws://127.0.0.1:8080", NULL, &terrain) != FORELAND_OK) quit("open", foreland_last_error());
  const ForelandLens lens = {.size = sizeof lens, .width_px = WIDTH, .height_px = HEIGHT, .fov_y = kFovY};
  foreland_set_lens(terrain, &lens);
  SDL_Window* window = makeWindow();
  const GLuint program = makeProgram();
  Mesh meshes[2] = {{0}, {0}};
  makeMesh(&meshes[0]), makeMesh(&meshes[1]);
  ForelandScene scene = FORELAND_INIT(ForelandScene);
  ForelandFrame frame = FORELAND_INIT(ForelandFrame);
  ForelandUpdate update = FORELAND_INIT(ForelandUpdate);
  ForelandEvent event = FORELAND_INIT(ForelandEvent);
  double gone = 0, begin = foreland_now();
  uint32_t drawn = 0, version = 0;
  for (int is_open = 1; is_open && gone < seconds; SDL_GL_SwapWindow(window)) {
    for (SDL_Event e; SDL_PollEvent(&e);) is_open &= e.type != SDL_QUIT;
    while (foreland_next_event(terrain, &event) == FORELAND_OK) {
      if (*event.message) fprintf(stderr, "window: %s\n", event.message);
      is_open &= event.kind != FORELAND_EVENT_REFUSED && event.kind != FORELAND_EVENT_FAILED;
    }
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (foreland_get_scene(terrain, &scene) != FORELAND_OK) begin = foreland_now();
    if ((gone = (foreland_now() - begin) / 1000) == 0) continue;
    const ForelandPose pose = poseAt(&scene, gone);
    foreland_frame(terrain, foreland_now(), &pose, &frame);
    for (; version < frame.version && foreland_next_update(terrain, &update) == FORELAND_OK; version = update.version)
      applyPart(&meshes[0], &update.terrain), applyPart(&meshes[1], &update.objects);
    if (version > 0) draw(program, meshes, &frame, &update, &scene), ++drawn;
  }
  const double ground = groundShare(argc > 3 ? argv[3] : NULL);
  printf("drew %u frames; the last: %d triangles, ground in %.0f %% of the picture, at most %.2f px wrong\n", drawn,
         (int)(meshes[0].index_count / 3), 100 * ground, frame.guaranteed_px);
  foreland_close(terrain);
  return ground > 0.2 && drawn > 1 ? 0 : 1;
}
