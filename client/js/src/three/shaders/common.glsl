uniform vec3 u_sun;      // towards the sun whose shadows the relief has
uniform vec3 u_up;       // away from the zero surface, at the eye
uniform int u_frame;     // planar, geographic, globe
// What only globes need is compiled for them alone: elsewhere it would cost a quarter of a frame on a processor that draws.
#ifdef GLOBE
#define IS_GLOBE (u_frame == 2)
#else
#define IS_GLOBE false
#endif
uniform vec2 u_heights;  // lowest, highest ground
