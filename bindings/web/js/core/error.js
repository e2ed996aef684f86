/** What every call of this package throws where it refuses: `code` for programs, `message` for people. */
export class CulletError extends Error {
  constructor(code, message, options) {
    super(`cullet: ${message}`, options);
    this.name = 'CulletError';
    this.code = code;
  }
}

// By the number that the module sends.
export const CODES = [undefined, 'memory', 'argument', 'id', 'mesh', 'camera', 'file', 'limit'];
