// The shader `picture` of scenes that show more than one volume and a core. It is `picture` with the lines that begin
// with `#scene` in place of those that begin with `#plain`: the shader of plain scenes has no code of these.
#import picture
