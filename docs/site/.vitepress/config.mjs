// The documentation site: `./dev docs site` renders the Markdown of the repository, unchanged.
//
// Links are those of a forge: relative, with the heading's fragment as GitHub makes it. A link to a file that is no page (a schema, an
// example scene) gets a copy of that file. The navigation is that of docs/README.md: its sections, and their pages in the order in which
// they are linked there. A page that it does not link comes last in the section of its folder.
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, statSync } from 'node:fs';
import { dirname, join, posix, relative, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitepress';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '../../..');
const sections = ['guide', 'reference', 'theory', 'lab']; // folders of docs/; a heading of docs/README.md begins with the name of each
const startPage = 'README.md';
const files = new Set(); // linked files that are no pages, relative to the root

const contentOf = (page) => readFileSync(join(root, page), 'utf8');
const titleOf = (page) => contentOf(page).match(/^# +(.*)$/m)[1].replaceAll('`', '');
const capitalized = (word) => word[0].toUpperCase() + word.slice(1);
const entry = (page) => ({ text: titleOf(page), link: `/${page.replace(/\.md$/, '')}` });

/** Returns the pages of a section: those that docs/README.md links, in that order, then the others of its folder. */
function pagesOf(section) {
    const body = contentOf('docs/README.md').split(/^## +/m).find((text) => text.toLowerCase().startsWith(section));
    if (!body) throw Error(`docs/README.md: found no section '${capitalized(section)}', expected a heading that begins with it`);
    const linked = [...body.matchAll(/\]\(([\w-]+\/[\w-]+\.md)/g)].map((match) => match[1]).filter((name) => name.startsWith(`${section}/`));
    const others = readdirSync(join(root, 'docs', section)).filter((name) => name.endsWith('.md')).sort();
    return [...new Set([...linked, ...others.map((name) => `${section}/${name}`)])].map((name) => `docs/${name}`);
}

function sidebar() {
    const groups = sections.map((section) => ({ text: capitalized(section), collapsed: false, items: pagesOf(section).map(entry) }));
    const development = ['CONTRIBUTING.md', 'CHANGELOG.md', 'SECURITY.md'];
    const examples = ['examples/cornell/README.md', 'viewer/README.md', 'viewer/loaders/README.md'];
    return [
        { text: 'Start', items: [{ text: 'Overview', link: '/' }, entry('docs/README.md')] },
        ...groups,
        { text: 'Development', items: development.map(entry) },
        { text: 'Examples and packages', items: examples.map(entry) },
    ];
}

/** Markdown-it plugin: the links of a forge as links of the site. */
function forgeLinks(md) {
    md.core.ruler.push('forge_links', ({ tokens, env }) => {
        const links = tokens.flatMap((token) => token.children ?? []).filter((token) => token.type === 'link_open');
        for (const link of links) rewrite(link, env.relativePath);
    });
}

function rewrite(link, page) {
    const href = link.attrGet('href');
    if (/^([a-z]+:|#)/.test(href)) return;
    const [path, fragment] = href.split('#');
    // VitePress knows the start page by its address.
    const from = page === 'index.md' ? startPage : page;
    const target = posix.join(posix.dirname(from), path);
    if (target.endsWith('.md')) {
        link.attrSet('href', `/${target === startPage ? '' : target}${fragment ? `#${fragment}` : ''}`);
    } else if (existsSync(join(root, target)) && statSync(join(root, target)).isFile()) {
        files.add(target);
        link.attrSet('target', '_self'); // no page: the browser opens it
    }
}

/** Returns the fragment that GitHub makes of a heading. */
const githubSlug = (heading) => heading.toLowerCase().replace(/[^\p{L}\p{N}_\- ]/gu, '').replaceAll(' ', '-');

function copyLinkedFiles({ outDir }) {
    for (const file of files) {
        mkdirSync(dirname(join(outDir, file)), { recursive: true });
        copyFileSync(join(root, file), join(outDir, file));
    }
}

/** Vite plugin: pages become modules that import Vue, and lie outside of the folder that has it. */
const vueForPages = {
    name: 'vue-for-pages',
    enforce: 'pre',
    resolveId(source, importer, options) {
        if (!/^vue(\/server-renderer)?$/.test(source) || !importer?.endsWith('.md')) return null;
        return this.resolve(source, join(root, 'docs/site/package.json'), { ...options, skipSelf: true });
    },
};

export default defineConfig({
    title: 'lightcook',
    description: 'Compresses baked light for games, and certifies the error',
    srcDir: relative(resolve(root, 'docs/site'), root),
    srcExclude: ['build/**', 'out/**', '**/node_modules/**', 'docs/site/**'],
    rewrites: { [startPage]: 'index.md' },
    cacheDir: join(root, 'build/site-cache'),
    outDir: process.env.LIGHTCOOK_SITE ?? join(root, 'build/site'),
    base: process.env.LIGHTCOOK_SITE_BASE ?? '/',
    markdown: { languageAlias: { ninja: 'make' }, anchor: { slugify: githubSlug }, config: (md) => md.use(forgeLinks) },
    vite: { plugins: [vueForPages] },
    buildEnd: copyLinkedFiles,
    themeConfig: {
        nav: sections.map((section) => ({ text: capitalized(section), link: entry(pagesOf(section)[0]).link, activeMatch: `/docs/${section}/` })),
        sidebar: sidebar(),
        outline: [2, 3],
        search: { provider: 'local' },
    },
});
