uniform vec3 u_sun;      // towards the sun whose shadows the relief has
uniform vec3 u_up;       // away from the zero surface, at the eye
uniform int u_frame;     // planar, geographic, globe
uniform vec2 u_heights;  // lowest, highest ground
