/* minimal.c, its main renamed, in one program with another Rust static library. Both catch panics of their own. */
int draw(void);
int other_catches_a_panic(void);

int main(void)
{
    if (!other_catches_a_panic()) {
        return 2;
    }
    return draw();
}
